# SPDX-License-Identifier: Apache-2.0
"""Template environment for generated files other than HTML."""

from __future__ import annotations

from pathlib import Path

import jinja2


def text_environment(folder: Path) -> jinja2.Environment:
    """Return the templates of a folder, with errors for unknown names and without the lines of blocks."""
    return jinja2.Environment(
        loader=jinja2.FileSystemLoader(folder),
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        undefined=jinja2.StrictUndefined,
        autoescape=False,
    )
