# SPDX-License-Identifier: Apache-2.0
"""Extensions of a paper: a structure of its model with additional effects, and further claims.

`papers/MODEL/beyond.toml` has the structure and the texts, `beyond.py` beside it the functions that compute.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from mehvar.base.names import identifier
from mehvar.base.schema import read_data

from .claims import Checks, Claim, ClaimKind, ClaimText, decide
from .paper import (
    Draw,
    FigureCaption,
    PaperFigure,
    check_functions,
    load_reproduction,
    paper_figures,
    paper_part,
)
from .runs import Runs

if TYPE_CHECKING:
    from mehvar.base.manifest import Manifest


@dataclass(frozen=True)
class BeyondWords:
    """Contents of a paper's `beyond.toml`.

    Attributes
    ----------
    page : str
        Page of the documentation with the details.
    structure : mapping of str to str
        Structural choices that differ from the defaults.
    text : tuple of str
        Effects that the structure adds.
    """

    page: str
    structure: Mapping[str, str]
    text: tuple[str, ...]
    figure: tuple[FigureCaption, ...]
    claim: tuple[ClaimText, ...]


@dataclass(frozen=True)
class Beyond:
    """An extension: its texts, its figures, and the functions that check its claims.

    Attributes
    ----------
    words : BeyondWords
        Its `beyond.toml`.
    figures : tuple of PaperFigure
        In the order of the texts.
    checks : mapping
        Functions that check, by the number of the claim.
    """

    words: BeyondWords
    figures: tuple[PaperFigure, ...]
    checks: Mapping[str, Checks]

    def claims(self, runs: Runs) -> list[Claim]:
        """Return the claims, findings of our own, with verdicts."""
        return [replace(claim, kind=ClaimKind.FINDING) for claim in decide(self.words.claim, self.checks, runs)]


@dataclass(frozen=True)
class Difference:
    """A difference between two structures: name, value in the paper's structure, value in the extension."""

    what: str
    paper: str
    beyond: str


def read_beyond(folder: Path, draw: Mapping[int, Draw], checks: Mapping[str, Checks]) -> Beyond:
    """Read a folder's `beyond.toml` and assign its functions.

    Parameters
    ----------
    folder : Path
        Folder of the paper.
    draw : mapping
        Functions of the extension's runs, whose `paper` has the paper's, by the number of the figure.
    checks : mapping
        Likewise, with the expected numbers, by the number of the claim.

    Raises
    ------
    InputError
        If the file is invalid, or its figures or claims do not match the functions.
    """
    path = folder / "beyond.toml"
    words = read_data(path, BeyondWords)
    check_functions(path, "claim", [text.number for text in words.claim], checks)
    return Beyond(words, paper_figures(path, words.figure, draw), checks)


def load_beyond(model: str) -> Beyond | None:
    """Return the extension of a model's paper; None without one."""
    if not (load_reproduction(model).folder / "beyond.toml").is_file():
        return None
    beyond: Beyond = paper_part(model, "beyond").BEYOND
    return beyond


def differences(paper: Manifest, beyond: Manifest) -> list[Difference]:
    """Return the sizes of both structures, and the names that only the extension has."""
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
    """Return the number of names, and the names that the other model lacks."""
    own = [name for name in these if name not in others]
    return f"{len(these)}" + (f", of these {', '.join(own)}" if own else "")
