# SPDX-License-Identifier: Apache-2.0
"""What lies beyond a paper: a structure of its model that has what the paper leaves to others, and claims about it.

`mehvar/papers/MODEL/beyond.toml` has structure and words, `beyond.py` beside it the functions that compute.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from mehvar.errors import InputError
from mehvar.names import identifier

from .claims import Check, Checks, Claim, ClaimText, Expected, decide
from .data import read_data
from .reproduction import FigureCaption, PaperFigure
from .runs import Runs

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from mehvar.manifest import Manifest

BothChecks: TypeAlias = Callable[[Runs, Runs, Expected], Sequence[Check]]
"""Runs the paper's model and the one beyond it, and returns the checks of a claim."""
BothFigure: TypeAlias = "Callable[[Runs, Runs], Figure]"
"""Draws runs of both."""


@dataclass(frozen=True)
class BeyondWords:
    """A paper's `beyond.toml`.

    Attributes
    ----------
    page : str
        Of the documentation, which says it at length.
    structure : mapping of str to str
        Structural choices that differ from the defaults.
    text : tuple of str
        What the structure adds.
    """

    __pydantic_config__ = {"extra": "forbid"}  # noqa: RUF012 - read by pydantic

    page: str
    structure: Mapping[str, str]
    text: tuple[str, ...]
    figure: tuple[FigureCaption, ...]
    claim: tuple[ClaimText, ...]


@dataclass(frozen=True)
class Beyond:
    """The words, and the functions that draw and check."""

    words: BeyondWords
    draw: Mapping[int, BothFigure]
    checks: Mapping[str, BothChecks]

    def claims(self, paper: Runs, runs: Runs) -> list[Claim]:
        """Return what became of the claims."""
        return decide(self.words.claim, self.checks_beside(paper), runs)

    def checks_beside(self, paper: Runs) -> dict[str, Checks]:
        """Return the checks with the paper's runs filled in."""
        return {number: partial(check, paper) for number, check in self.checks.items()}

    def figures(self, paper: Runs) -> list[PaperFigure]:
        """Return the figures with the paper's runs filled in."""
        return [
            PaperFigure(f.number, f.title, f.caption, partial(self.draw[f.number], paper), f.claims)
            for f in self.words.figure
        ]


@dataclass(frozen=True)
class Difference:
    """One row of how the structure differs from the paper's: what, the paper's, beyond."""

    what: str
    paper: str
    beyond: str


def read_beyond(folder: Path, draw: Mapping[int, BothFigure], checks: Mapping[str, BothChecks]) -> Beyond:
    """Bind `beyond.toml` of a folder to functions: `draw` by the number of the figure, `checks` by that of the claim.

    Raises
    ------
    InputError
        If the file is wrong, or figures or claims are not those that the functions are for.
    """
    path = folder / "beyond.toml"
    words = read_data(path, BeyondWords)
    for kind, numbers, functions in (
        ("figure", [figure.number for figure in words.figure], list(draw)),
        ("claim", [text.number for text in words.claim], list(checks)),
    ):
        if numbers != functions:
            raise InputError(f"{path}: {kind}s {numbers} are not those that the code has, {functions}")
    return Beyond(words, draw, checks)


def load_beyond(model: str) -> Beyond:
    """Return what lies beyond a model's paper."""
    module = importlib.import_module(f"{__package__}.{identifier(model)}.beyond")
    beyond: Beyond = module.BEYOND
    return beyond


def differences(paper: Manifest, beyond: Manifest) -> list[Difference]:
    """Return how large both structures are, and what the second has that the first has not, by name."""
    rows = [
        Difference("operations of the rates", *(str(m.functions["rhs"].operations) for m in (paper, beyond))),
        *(
            Difference(
                f"operations of law {name}", *(str(m.functions[identifier(name)].operations) for m in (paper, beyond))
            )
            for name in paper.controllers
            if name in beyond.controllers
        ),
    ]
    groups = (
        ("states", [q.name for q in paper.states], [q.name for q in beyond.states]),
        ("inputs", [q.name for q in paper.inputs], [q.name for q in beyond.inputs]),
        ("laws", [*paper.controllers], [*beyond.controllers]),
        ("scenarios", [*paper.scenarios], [*beyond.scenarios]),
    )
    rows += [Difference(what, _only(old, new), _only(new, old)) for what, old, new in groups if old != new]
    sizes = (str(len(m.parameters)) for m in (paper, beyond))
    return [*rows, Difference("parameters of the plant", *sizes)]


def _only(these: Sequence[str], others: Sequence[str]) -> str:
    """Say how many there are, and the names that the others have not."""
    own = [name for name in these if name not in others]
    return f"{len(these)}" + (f", of these {', '.join(own)}" if own else "")
