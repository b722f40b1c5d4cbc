# SPDX-License-Identifier: Apache-2.0
"""Templates of HTML pages, with escaped texts and formulas as MathML."""

from __future__ import annotations

import base64
import functools
import html
import io
import json
import re
import unicodedata
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import jinja2
from markupsafe import Markup, escape

from mehvar.base.errors import printable
from mehvar.base.units import pretty_unit
from mehvar.codegen.equations.mathml import mathml

_TEMPLATES = Path(__file__).parent / "templates"
_FONT = _TEMPLATES / "fonts" / "stix-two-math.woff"
_FONT_PLACE = "/* font of the formulas */"
"""Position in the style sheet for the font of formulas."""


def typeset(latex: str) -> Markup:
    """Convert LaTeX to MathML, which browsers display without scripts."""
    return Markup(mathml(latex))


def typeset_within(text: str) -> Markup:
    """Convert words with LaTeX between dollar signs to escaped words with MathML."""
    parts = text.split("$")
    return Markup("").join(typeset(part) if i % 2 else part for i, part in enumerate(parts))


def powers(text: str) -> str:
    """Return text with 1e-05 as 1×10⁻⁵ and 0.0e+00 as 0."""

    def power(match: re.Match[str]) -> str:
        return f"{match[1]}×10^{int(match[2])}" if match[1].strip("-0.") else "0"

    return pretty_unit(re.sub(r"(?<!\w)(-?[\d.]+)e([+-]?\d+)", power, text))


def quantities(value: object) -> Markup:
    """Return a value or words with typographic minus signs, exponents, degrees and thousands; names stay."""
    text = powers(re.sub(r"(?<=\d) deg\b", "°", str(escape(value)).replace("+-", "±")))
    text = re.sub(r"(?<![\w.,−-])\d{5,}(?![\w.])", lambda match: f"{int(match[0]):,}".replace(",", "\u202f"), text)
    return Markup(re.sub(r"(?<![\w.\-])-(?=\d)", "−", text))


def _shown(value: object) -> object:
    """Return a value for a template; remove control characters from texts."""
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
        Further filters besides `quantities`, and `mathml` and `words`, which are `typeset` and `typeset_within`.
    **content
        Variables of the template.
    """
    text = _environment(frozenset(filters.items())).get_template(template).render(content)
    return text.replace(_FONT_PLACE, _formula_font(text), 1)


def asset(name: str) -> Markup:
    """Return a style sheet or a script below `mehvar/templates` as page content."""
    return Markup((_TEMPLATES / name).read_text(encoding="utf-8"))


def script_data(data: object) -> Markup:
    """Return plain data as JSON that is safe in a script element."""
    return Markup(json.dumps(data, ensure_ascii=False, separators=(",", ":")).replace("<", "\\u003c"))


@functools.lru_cache(maxsize=8)
def _environment(filters: frozenset[tuple[str, Callable[..., Any]]]) -> jinja2.Environment:
    """Return the template environment with given filters, cached because compiling templates is slow."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(_TEMPLATES),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=_shown,
    )
    ours = {"mathml": typeset, "words": typeset_within, "quantities": quantities}
    environment.filters |= ours | dict(filters)
    return environment


def _formula_font(text: str) -> str:
    """Return the style that embeds a font for a page's formulas; empty for a page without formulas.

    Browsers need a font with mathematical tables for subscripts and brackets, which many systems lack.
    """
    formulas = "".join(re.findall(r"<math\b.*?</math>", text, re.DOTALL))
    written = re.sub(r"<[^>]*>", "", re.sub("<m(sqrt|root)", r"√\g<0>", formulas))  # browsers add the sign of a root
    signs = frozenset(html.unescape(written))
    if not signs:
        return ""
    data = base64.b64encode(_font(signs)).decode()
    return f'@font-face {{ font-family: Formulas; src: url(data:font/woff;base64,{data}) format("woff"); }}'


@functools.lru_cache(maxsize=16)
def _font(signs: frozenset[str]) -> bytes:
    """Return the font reduced to the given characters; without fontTools the whole font, six times as large."""
    try:
        from fontTools import subset
        from fontTools.ttLib import TTFont
    except ImportError:  # comes with Matplotlib
        return _FONT.read_bytes()
    with TTFont(_FONT) as font:
        part = subset.Subsetter(subset.Options())
        part.populate(unicodes=[ord(sign) for sign in signs | _italic(signs)])
        part.subset(font)
        content = io.BytesIO()
        font.save(content)
    return content.getvalue()


def _italic(signs: frozenset[str]) -> set[str]:
    """Return the italic letters with which browsers show one-letter names."""
    block = map(chr, range(0x1D434, 0x1D7CC))
    italic = (sign for sign in block if unicodedata.name(sign, "").startswith("MATHEMATICAL ITALIC"))
    plain = {sign: chr(int(unicodedata.decomposition(sign).split()[1], 16)) for sign in (*italic, "\u210e")}
    return {sign for sign, letter in plain.items() if letter in signs}
