# SPDX-License-Identifier: Apache-2.0
"""Equations of a generated folder in LaTeX, read from `equations.md`."""

from __future__ import annotations

import re

from mehvar.base.manifest import Manifest

from .generated import generated_text

_SECTION = re.compile(r"^### Rates of the states$(.*?)(?=^##|\Z)", re.MULTILINE | re.DOTALL)
_FORMULA = re.compile(r"^\|[^|]*\| \$`(.*?)`\$ \||^```math\n(.*?)\n```$", re.MULTILINE | re.DOTALL)
"""Pattern of a formula, in a table row or separate."""


def rates(manifest: Manifest) -> list[str]:
    """Return the equations of the states' rates, if the folder has the page.

    Raises
    ------
    InputError
        If the page was edited.
    """
    page = "equations.md"
    section = _SECTION.search(generated_text(manifest, page)) if (manifest.folder / page).is_file() else None
    return [match[1] or match[2] for match in _FORMULA.finditer(section[1])] if section else []
