# SPDX-License-Identifier: Apache-2.0
"""The HTML pages of mehvar: one environment for all templates, everything escaped, formulas as MathML."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import jinja2
from markupsafe import Markup

from mehvar.base.errors import printable
from mehvar.codegen.equations.mathml import mathml

_TEMPLATES = Path(__file__).parent / "templates"


def typeset(latex: str) -> Markup:
    """Return LaTeX as MathML, which a browser shows without help."""
    return Markup(mathml(latex))


def typeset_within(text: str) -> Markup:
    """Return words with LaTeX between dollar signs as escaped words with MathML."""
    parts = text.split("$")
    return Markup("").join(typeset(part) if i % 2 else part for i, part in enumerate(parts))


def _shown(value: object) -> object:
    """Return a value for a template, its text without control characters."""
    if not isinstance(value, str):
        return value
    return Markup(printable(value)) if isinstance(value, Markup) else printable(value)


def page(template: str, filters: Mapping[str, Callable[..., Any]] = MappingProxyType({}), **content: object) -> str:
    """Return a page as text.

    Parameters
    ----------
    template : str
        File below `mehvar/templates`; it may include others by their path from there.
    filters : mapping of str to callable
        What the template uses beyond `mathml` and `words`, which are `typeset` and `typeset_within`.
    **content
        What it is about.
    """
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(_TEMPLATES),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=_shown,
    )
    environment.filters |= {"mathml": typeset, "words": typeset_within, **filters}
    return environment.get_template(template).render(content)
