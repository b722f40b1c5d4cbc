# SPDX-License-Identifier: Apache-2.0
"""Generated files that are no HTML: one environment for all their templates."""

from __future__ import annotations

from pathlib import Path

import jinja2


def text_environment(folder: Path) -> jinja2.Environment:
    """Return the templates of a folder; a name that they lack is an error, lines of nothing but blocks vanish."""
    return jinja2.Environment(
        loader=jinja2.FileSystemLoader(folder),
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        undefined=jinja2.StrictUndefined,
        autoescape=False,
    )
