# SPDX-License-Identifier: Apache-2.0
"""Write docs/reference/capabilities.md: which features of a model go where, from the table that refuses the others."""

from __future__ import annotations

from pathlib import Path

from mehvar.base.capabilities import EXCLUSIONS, FEATURES, Feature, Place

PAGE = Path(__file__).parents[1] / "reference" / "capabilities.md"
_HEAD = """# Capabilities

What of a model goes where. [The table](../../mehvar/base/capabilities.py), which every refusal follows, is printed by
`python -m docs.site.capabilities`. Runs and batches take every feature by one loop, on each backend, with the methods
and ways to sample below. A feature without a row is taken everywhere.

| feature | declared by |"""
_BESIDE = """
## Beside one another

`generate` refuses a system with both.

| feature | cannot be combined with | reason |
|---|---|---|"""


def page() -> str:
    """Return the text of the page."""
    head = f"{_HEAD} {' | '.join(place.value[1] for place in Place)} |"
    rule = "|" + "---|" * (2 + len(Place))
    rows = [_row(feature) for feature in FEATURES if feature.refused or feature.limited]
    beside = [f"| {one.name} | {other.name} | {reason} |" for one, other, reason in EXCLUSIONS]
    return "\n".join([head, rule, *rows, _BESIDE, *beside]) + "\n"


def _row(feature: Feature) -> str:
    cells = ["**no**" if place in feature.refused else feature.limited.get(place, "yes") for place in Place]
    return f"| {feature.name} | {', '.join(f'`{name}`' for name in feature.fields)} | {' | '.join(cells)} |"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
