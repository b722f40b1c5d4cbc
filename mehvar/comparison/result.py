# SPDX-License-Identifier: Apache-2.0
"""Results of a comparison of two versions, as plain frozen values."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from typing import Any

from rich.text import Text

from mehvar.codegen.diff.report import Comparison, EquationChange, ModelStatus, ParameterChange
from mehvar.terminal import Line, finite, html_text, plain_text

from .consequences import Consequences
from .document import Block, Group, Words
from .effects import effects
from .equations import Equations, counted
from .runs import Overlay
from .text import lines

SCHEMA = 1
_STYLES = dict.fromkeys((ModelStatus.SAME, ModelStatus.NAMES, ModelStatus.PICTURE), "bold green")
_STYLES[ModelStatus.UNDECIDED] = "bold yellow"


@dataclass(frozen=True, repr=False)
class ModelDiff:
    """Changes of one model.

    Attributes
    ----------
    model : str
        Its name.
    status : ModelStatus
        Status in one word.
    comparison : Comparison
        Equation by equation; empty for a model that only one side has.
    consequences : Consequences or None
        Effects of the change; None if nothing changed or no run was possible.
    overlay : Overlay or None
        The run that differs most, in both versions; None if none differs.
    variant : str
        The structural choices that differ from the defaults, as in "inertia=ball"; empty for the default structure.
    parts : tuple of str
        Changes of a spacecraft, part by part.
    notes : tuple of str
        Further remarks: stale folders, structures that were not compared.
    structures : tuple of ModelDiff
        Other compared structures with additional changes.
    """

    model: str
    status: ModelStatus
    comparison: Comparison
    consequences: Consequences | None = None
    overlay: Overlay | None = field(default=None, compare=False, repr=False)
    variant: str = ""
    parts: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    structures: tuple[ModelDiff, ...] = ()

    @property
    def name(self) -> str:
        """Name of the model; for another structure than the default, with its choices."""
        return " ".join(filter(None, (self.model, self.variant)))

    @property
    def differs(self) -> bool:
        """True if any compared structure differs in more than the form of equations."""
        return self.status is not ModelStatus.SAME or any(other.differs for other in self.structures)

    def __iter__(self) -> Iterator[ModelDiff]:
        """Yield the default structure, then the others."""
        return iter((self, *self.structures))

    @property
    def changed(self) -> tuple[EquationChange, ...]:
        """Equations whose value differs or is undecided, by their own text or through definitions."""
        return self.comparison.changed

    @property
    def added(self) -> tuple[EquationChange, ...]:
        """Equations that only the new side has."""
        return self.comparison.added

    @property
    def removed(self) -> tuple[EquationChange, ...]:
        """Equations that only the old side has."""
        return self.comparison.removed

    @property
    def equivalent(self) -> tuple[EquationChange, ...]:
        """Equations with a different form or name but the same meaning."""
        return self.comparison.equivalent

    @property
    def parameters(self) -> tuple[ParameterChange, ...]:
        """Names, units, bounds, sources and values that differ."""
        return self.comparison.parameters

    def to_json(self) -> dict[str, Any]:
        """Return the contents as plain lists, dicts and strings."""
        follows = None if self.consequences is None else asdict(self.consequences)
        if follows is not None:
            for spectrum in (follows, *follows["loops"]):
                spectrum["eigenvalues"] = [[[z.real, z.imag] for z in pair] for pair in spectrum["eigenvalues"]]
        return {
            **self.comparison.to_json(),
            "model": self.model,
            "status": self.status.value,
            "differs": self.differs,
            "consequences": follows,
            "variant": self.variant,
            "parts": list(self.parts),
            "notes": list(self.notes),
            "structures": [other.to_json() for other in self.structures],
        }

    @property
    def counts(self) -> str:
        """Numbers of equations by verdict."""
        return counted(self.comparison)

    @property
    def blocks(self) -> list[Block]:
        """Contents of the report on this structure."""
        blocks: list[Block] = [*(Words(line, strong=True) for line in self.parts), *map(Words, self.notes)]
        blocks += Equations(self.comparison).blocks()
        if self.consequences:
            follows = effects(self.name, self.consequences, self.overlay, self.comparison)
            blocks.append(Group("consequences", [*follows]))
        return blocks

    def lines(self) -> Iterator[Line]:
        """Yield the report on the model."""
        for part in self:
            style = _STYLES.get(part.status, "bold red")
            yield 0, Text.assemble((f"{part.name}: ", "bold"), (part.status.headline, style), "   ", part.counts)
            yield from lines(part.blocks, 2)

    def __repr__(self) -> str:
        return plain_text(self.lines())

    def _repr_html_(self) -> str:
        return html_text(self.lines())


@dataclass(frozen=True)
class Diff:
    """Changes between two versions.

    Attributes
    ----------
    old, new : str
        Names of the versions.
    models : tuple of ModelDiff
        All models of either side.
    """

    old: str
    new: str
    models: tuple[ModelDiff, ...]

    @property
    def parts(self) -> list[ModelDiff]:
        """Every compared structure of every model."""
        return [part for model in self.models for part in model]

    @property
    def differs(self) -> bool:
        """True if any model differs."""
        return any(model.differs for model in self.models)

    def lines(self) -> Iterator[Line]:
        """Yield the report on every model."""
        yield 0, Text(f"{self.old} -> {self.new}", "dim")
        for model in self.models:
            yield from model.lines()

    def to_json(self) -> dict[str, Any]:
        """Return the contents in the form of docs/reference/diff-json.md."""
        models = [model.to_json() for model in self.models]
        return {"schema": SCHEMA, "old": self.old, "new": self.new, "differs": self.differs, "models": models}

    def json_text(self) -> str:
        """Return the JSON text."""
        return json.dumps(finite(self.to_json()), indent=1, ensure_ascii=False) + "\n"
