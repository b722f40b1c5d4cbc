# SPDX-License-Identifier: Apache-2.0
"""Reproduction of a paper: figures, claims, an animation and a batch.

A folder papers/MODEL, beside models/, holds a paper's data:

- captions.toml: citation, `cover` figure, titles and captions, the claims of each figure, the runs of the animation;
- claims.toml: each claim in words, its note, expected numbers, readings of damaged text;
- statements.toml: counts of equations, tables and figures; sentences with the claims that they rest on;
- expected.toml: the paper's table of numbers, if any;
- beyond.toml, optional: the extension's structure, page, additions, figures and claims;
- study.toml: the batch: laws, dispersions, success.

A claim holds under a reading if its essential checks hold; a statement gets the verdict of its worst claim. Tests
check that checks, expected values or parameters contain every number in a claim or caption. `reproduction.py` has a
function for each figure and claim, and its REPRODUCTION binds them to the data.
Figures with *time* as horizontal axis become charts.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, TypeAlias

from mehvar.base.errors import InputError
from mehvar.base.names import identifier
from mehvar.base.schema import read_data
from mehvar.codegen.workspace import Tree, find_tree, installed_tree, load_paper
from mehvar.pictures.run import panels_picture
from mehvar.pictures.style import style
from mehvar.runtime.model.catalogue import is_installed

from .claims import Checks, Claim, ClaimText, Readings, decide
from .runs import Runs
from .statements import Statements
from .study import Study

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from mehvar.base.manifest import Manifest

    RunPicture: TypeAlias = Callable[[xr.Dataset, Manifest], Figure]

Draw: TypeAlias = "Callable[[Runs], Figure]"
"""Function that draws a figure from runs."""


@dataclass(frozen=True)
class FigureCaption:
    """Texts of a figure, by its number in the paper; `claims` are the numbers of the claims that it supports.

    `label` is the paper's name for it, if the paper numbers several kinds of pictures. If the picture is `lost`, the
    caption ends with the common text about lost pictures.
    """

    number: int
    title: str
    caption: str
    label: str = ""
    lost: bool = False
    claims: tuple[str, ...] = ()


@dataclass(frozen=True)
class SceneRun:
    """A run of the animation: its title, its law, and the settings that it has otherwise."""

    title: str
    law: str
    set: Mapping[str, float | str] = field(default_factory=dict)


@dataclass(frozen=True)
class SceneCaption:
    """Texts of the animation, its runs of a scenario, and the variables of each panel beside it by title."""

    title: str
    caption: str
    signals: Mapping[str, tuple[str, ...]]
    run: tuple[SceneRun, ...]
    scenario: str = "paper"


@dataclass(frozen=True)
class Captions:
    """Contents of a paper's `captions.toml`: authors, reading, and texts of figures and animation.

    `cover` is the number of the figure that represents the paper on the overview.
    """

    citation: str
    cover: int
    readings: tuple[str, ...]
    scene: SceneCaption
    figure: tuple[FigureCaption, ...]
    lost_picture: str = ""


@dataclass(frozen=True)
class Claims:
    """Contents of a paper's `claims.toml`."""

    claim: tuple[ClaimText, ...]


@dataclass(frozen=True)
class PaperFigure:
    """A figure of the paper: its number, the function `draw`, and the numbers of the claims that it supports.

    `label` is the paper's name for it, if it differs from that number.
    """

    number: int
    title: str
    caption: str
    draw: Draw
    claims: tuple[str, ...] = ()
    label: str = ""


@dataclass(frozen=True)
class Reproduction:
    """A paper's texts, and the functions that draw its figures and check its claims.

    Attributes
    ----------
    folder : Path
        Folder of the paper.
    captions, study, texts, statements
        Contents of `captions.toml`, `study.toml`, `claims.toml` and `statements.toml`.
    figures : tuple of PaperFigure
        In the order of the captions.
    checks : mapping
        Checks of claims, by number.
    readings : mapping
        Checks of claims under other readings of the paper.
    more_claims : callable
        Returns further claims, such as the rows of a table.
    picture : callable
        Draws any run of the model.
    """

    folder: Path
    captions: Captions
    study: Study
    figures: tuple[PaperFigure, ...]
    texts: tuple[ClaimText, ...]
    checks: Mapping[str, Checks]
    readings: Readings
    statements: Statements
    more_claims: Callable[[Runs], Sequence[Claim]]
    picture: RunPicture

    def claims(self, runs: Runs) -> list[Claim]:
        """Return the paper's claims with verdicts."""
        return [*decide(self.texts, self.checks, runs, self.readings), *self.more_claims(runs)]


def read_reproduction(
    folder: Path,
    *,
    draw: Mapping[int, Draw],
    checks: Mapping[str, Checks],
    picture: RunPicture,
    readings: Readings | None = None,
    more_claims: Callable[[Runs], Sequence[Claim]] = lambda _: (),
) -> Reproduction:
    """Read the texts in a folder and assign its functions.

    Parameters
    ----------
    folder : Path
        Folder of the paper.
    draw : mapping
        Functions that draw, by the number of the figure.
    checks : mapping
        Functions that check, by the number of the claim.
    picture : callable
        Draws any run of the model.
    readings : mapping, optional
        Further checks, by the number of the claim and the name of the reading.
    more_claims : callable
        Returns claims beside those of `claims.toml`.

    Raises
    ------
    InputError
        If a file is invalid, or its figures or claims do not match the functions.
    """
    captions = read_data(folder / "captions.toml", Captions)
    figures = paper_figures(folder / "captions.toml", captions.figure, draw, captions.lost_picture)
    texts = read_data(folder / "claims.toml", Claims).claim
    check_functions(folder / "claims.toml", "claim", [text.number for text in texts], checks)
    readings = readings or {}
    for text in texts:
        names = [reading.name for reading in text.reading]
        check_functions(folder / "claims.toml", f"claim {text.number}: reading", names, readings.get(text.number, {}))
    study = read_data(folder / "study.toml", Study)
    statements = read_data(folder / "statements.toml", Statements)
    return Reproduction(folder, captions, study, figures, texts, checks, readings, statements, more_claims, picture)


def paper_figures(
    path: Path, captions: Sequence[FigureCaption], draw: Mapping[int, Draw], lost_picture: str = ""
) -> tuple[PaperFigure, ...]:
    """Return the figures of a file with the functions that draw them."""
    check_functions(path, "figure", [text.number for text in captions], draw)
    return tuple(
        PaperFigure(text.number, text.title, f"{text.caption} {lost_picture}" if text.lost else text.caption,
                    draw[text.number], text.claims, text.label)
        for text in captions
    )  # fmt: skip


def check_functions(path: Path, kind: str, numbers: Sequence[object], functions: Iterable[object]) -> None:
    """Refuse a file whose numbered entries differ from the functions of the code."""
    if list(numbers) != list(functions):
        raise InputError(f"{path}: {kind}s {list(numbers)} do not match the functions of the code, {list(functions)}")


def papers_tree() -> Tree:
    """Return the project with papers to reproduce: the current one or else mehvar's checkout.

    Raises
    ------
    InputError
        If neither has one, for example if mehvar is installed from a wheel.
    """
    for tree in _trees():
        if paper_models(tree):
            return tree
    raise InputError(
        f"no paper to reproduce: no project at or above {Path.cwd()} has papers/MODEL/reproduction.py. "
        "Run the command in a checkout of mehvar, which has its papers"
    )


def paper_models(tree: Tree) -> list[str]:
    """Return the models of a project that have a paper to reproduce."""
    return [name for name in tree.papers if _reproduction(tree, name).is_file()]


def paper_part(model: str, part: str) -> ModuleType:
    """Return a module from the folder of a model's paper.

    Raises
    ------
    InputError
        If the model has no paper to reproduce.
    """
    tree = _home(model)
    if tree is None:
        raise InputError(f"no paper of {model}: papers/{model}/reproduction.py was not found here or beside mehvar")
    return load_paper(tree, identifier(model), part)


def load_reproduction(model: str) -> Reproduction:
    """Return the reproduction of a model's paper."""
    reproduction: Reproduction = paper_part(model, "reproduction").REPRODUCTION
    return reproduction


def run_picture(dataset: xr.Dataset, manifest: Manifest) -> Figure:
    """Draw a run as its model's paper does for that law, by default with one panel per kind and unit.

    Parameters
    ----------
    dataset : xarray.Dataset
        Result of `mehvar.runtime.run.results.to_dataset` or `open_result`.
    manifest : Manifest
        Manifest of the model.

    Raises
    ------
    InputError
        If matplotlib is not installed.
    """
    with style():
        published = has_paper(manifest.model) and dataset.attrs["controller"] in manifest.controllers
        draw = load_reproduction(manifest.model).picture if published else panels_picture
        return draw(dataset, manifest)


def result_picture(dataset: xr.Dataset, manifest: Manifest) -> Figure:
    """Draw a stored result, in the paper's way if the installed model is that of the result."""
    with style():
        draw = run_picture if is_installed(manifest.model, manifest.hash) else panels_picture
        return draw(dataset, manifest)


def has_paper(model: str) -> bool:
    """Return True for a model with a paper to reproduce."""
    return _home(model) is not None


def _home(model: str) -> Tree | None:
    return next((tree for tree in _trees() if _reproduction(tree, identifier(model)).is_file()), None)


def _trees() -> list[Tree]:
    """Return the current project and the project of the installed mehvar."""
    return [tree for tree in (find_tree(Path.cwd()), installed_tree()) if tree is not None]


def _reproduction(tree: Tree, model: str) -> Path:
    return tree.root / "papers" / model / "reproduction.py"
