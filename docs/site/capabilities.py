# SPDX-License-Identifier: Apache-2.0
"""Write docs/reference/capabilities.md from the table of features and the operations that refuse them."""

from __future__ import annotations

from pathlib import Path

from mehvar.base.capabilities import EXCLUSIONS, FEATURES, Feature, Operation

PAGE = Path(__file__).parents[1] / "reference" / "capabilities.md"
_HEAD = """# Capabilities

Operations that support each feature of a model, from [the table](../../mehvar/base/capabilities.py) that mehvar uses
to refuse the others. `python -m docs.site.capabilities` writes this page. Runs and batches support the same features,
on each backend. Every operation supports the features that have no row here.

| feature | declared by |"""
_BESIDE = """
## Excluded combinations

`generate` refuses a system with both features.

| feature | cannot be combined with | reason |
|---|---|---|"""


def page() -> str:
    """Return the text of the page."""
    head = f"{_HEAD} {' | '.join(place.value[1] for place in Operation)} |"
    rule = "|" + "---|" * (2 + len(Operation))
    rows = [_row(feature) for feature in FEATURES if feature.refused or feature.limited]
    beside = [f"| {one.name} | {other.name} | {reason} |" for one, other, reason in EXCLUSIONS]
    return "\n".join([head, rule, *rows, _BESIDE, *beside]) + "\n"


def _row(feature: Feature) -> str:
    cells = ["**no**" if place in feature.refused else feature.limited.get(place, "yes") for place in Operation]
    return f"| {feature.name} | {', '.join(f'`{name}`' for name in feature.fields)} | {' | '.join(cells)} |"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
