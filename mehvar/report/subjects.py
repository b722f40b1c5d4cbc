# SPDX-License-Identifier: Apache-2.0
"""Sections about a model or a run, from committed equations and results."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING

from markupsafe import Markup

from mehvar.base.errors import bad_value
from mehvar.base.manifest import Manifest
from mehvar.codegen.equations.document import Document, Row
from mehvar.codegen.equations.formula import Printer, SymbolNames
from mehvar.codegen.equations.mathml import mathml
from mehvar.codegen.equations.spelling import PAGE
from mehvar.pictures.style import case_text, require_matplotlib
from mehvar.reproduction.paper import result_picture
from mehvar.reproduction.runs import Runs as PaperRuns
from mehvar.runtime.model.catalogue import find_model, is_installed
from mehvar.runtime.model.generated import check_unedited
from mehvar.runtime.model.model import Model, load
from mehvar.runtime.run.metrics import metrics, metrics_of
from mehvar.runtime.run.options import OPTIONS
from mehvar.runtime.run.results import to_dataset

from .page import Drawing, Formulas, Section, Stage, Table, Text
from .picture import picture
from .scene import scene
from .tables import model_tables

if TYPE_CHECKING:
    import xarray as xr


def model_sections(model: Model) -> list[Section]:
    """Return the sections of a model: equations, numbers, and a run of each law in the first scenario.

    Raises
    ------
    InputError
        If matplotlib is not installed.
    """
    require_matplotlib()
    manifest, runs = model.manifest, PaperRuns(model)
    case = manifest.scenario(None)
    datasets = {law: to_dataset(runs(law, case.name)) for law in manifest.controllers}
    return [
        *_animation(_stage(datasets, model)),
        *_derivation(manifest.folder),
        Section("numbers", "Quantities and parameters", [Table(*table) for table in model_tables(manifest)]),
        *(_run(dataset, manifest, f"run-{law}", f"Run: {law}, {case.name}") for law, dataset in datasets.items()),
        _origin(manifest, next(iter(datasets.values())).attrs["versions"] if datasets else "{}"),
    ]


def run_sections(
    dataset: xr.Dataset, manifest: Manifest, model: Model | str | os.PathLike[str] | None = None
) -> list[Section]:
    """Return the sections of a run: results, numbers, and the equations if they match the run.

    Parameters
    ----------
    dataset : xarray.Dataset
        Result of `mehvar.simulate` or `mehvar.open_result`.
    manifest : Manifest
        Manifest of the run.
    model : Model, str or path, optional
        As of `run_stage`.

    Raises
    ------
    InputError
        If matplotlib is not installed, or `model` is not the run's.
    """
    require_matplotlib()
    values, origins = (json.loads(dataset.attrs[name]) for name in ("parameters", "parameter_origins"))
    law = manifest.controllers.get(dataset.attrs["controller"])
    own = law.parameters if law else ()
    meanings = {
        q.name: (q.unit, q.description)
        for group in (manifest.states, manifest.parameters, manifest.scenario_parameters, own)
        for q in group
    }

    def row(name: str, value: float) -> tuple[str, ...]:
        return (name, f"{value:g}", *meanings.get(name, ("", "")))

    rows = [(*row(name, value), origins[name]) for name, value in values.items()]
    start = [row(name, value) for name, value in json.loads(dataset.attrs["initial"]).items()]
    options = [(name, str(value), OPTIONS[name].unit) for name, value in json.loads(dataset.attrs["options"]).items()]
    return [
        *_animation(run_stage(dataset, manifest, model)),
        _run(dataset, manifest, "run", "Run"),
        Section(
            "values",
            "Values",
            [
                Table("Parameters", ("name", "value", "unit", "meaning", "from"), rows),
                Table("States at the start", ("name", "value", "unit", "meaning"), start),
                Table("Options", ("name", "value", "unit"), options),
            ],
        ),
        *installed_derivation(manifest.model, manifest.hash),
        _origin(manifest, dataset.attrs["versions"]),
    ]


def run_stage(
    dataset: xr.Dataset, manifest: Manifest, model: Model | str | os.PathLike[str] | None = None
) -> Stage | None:
    """Return the animation of a run by its model's geometry, or None without one.

    The functions of `model` compute the points; default: the installed model, if it has the version of the run.

    Raises
    ------
    InputError
        If `model` is not the run's.
    """
    name = manifest.model
    if model is not None:
        own = model if isinstance(model, Model) else load(model)
        if own.manifest.hash != manifest.hash:
            given, wanted = (f"{of.model} {of.hash[:12]}" for of in (own.manifest, manifest))
            raise bad_value("model", given, f"that of the run, {wanted}", "the call")
    elif is_installed(name, manifest.hash):
        own = load(name)
    else:
        return None
    title = f"{dataset.attrs['controller']}, {case_text(dataset.attrs)}"
    return _stage({title: dataset}, own)


def _stage(datasets: Mapping[str, xr.Dataset], model: Model) -> Stage | None:
    shapes = model.manifest.geometry
    if not shapes or not datasets:
        return None
    caption = f"Shown: {', '.join(shape.name for shape in shapes)}. Drag the picture to look from another side."
    return Stage(model.manifest.model, "Motion", caption, scene(datasets, model))


def _animation(stage: Stage | None) -> list[Section]:
    return [Section("animation", "Animation", [stage])] if stage else []


def _derivation(folder: Path) -> list[Section]:
    """Return the derived equations in order, and the states' rates, if the folder has them."""
    if not (folder / "equations.json").is_file():
        return []
    document = Document.read(folder)
    if document.manifest is not None:
        check_unedited(document.manifest)
    printer = Printer(document.nodes, SymbolNames(document.latex), PAGE)
    rates = [row for row in document.results if row.kind == "rhs"]
    groups = [("Rates of the states", rates)]
    groups += [(title, list(rows)) for title, rows in groupby(document.definitions, lambda row: row.section)]
    blocks = [Formulas(title or "Derivation", list(_formulas(rows, printer))) for title, rows in groups if rows]
    return [Section("derivation", "Derivation", blocks)]


def _formulas(rows: Sequence[Row], printer: Printer) -> Iterator[tuple[str, Markup]]:
    for row in rows:
        unit = f" [{row.unit}]" if row.unit not in ("", "1") else ""
        formula = mathml(f"{row.latex} = {printer.text(row.node)}")
        yield f"{row.number} {row.title}{unit}".strip(), Markup(formula)


def installed_derivation(model: str, digest: str) -> list[Section]:
    """Return the derivation of the installed model with this hash, or nothing."""
    return _derivation(find_model(model).folder) if is_installed(model, digest) else []


def _run(dataset: xr.Dataset, manifest: Manifest, anchor: str, title: str) -> Section:
    """Return the section about a run: reason of its end, picture and metrics."""
    about = dataset.attrs
    known = metrics_of(manifest, about["controller"], list(map(str, dataset.data_vars)))
    values = metrics(dataset, manifest)
    rows = [(name, f"{value:.6g}", known[name].unit, known[name].description) for name, value in values.items()]
    text = f"Scenario {case_text(about)}: {about['reason']}, t = {float(about['t_stop']):g} s."
    drawn = picture(f"{anchor}-picture", title, str(about["exceeded"]), result_picture(dataset, manifest))
    return Section(
        anchor, title, [Text(text), Drawing(drawn), Table("Metrics", ("metric", "value", "unit", "meaning"), rows)]
    )


def _origin(manifest: Manifest, versions: str) -> Section:
    structure = ", ".join(f"{name} = {value}" for name, value in manifest.structure.items())
    facts = [("model", manifest.model), ("hash", manifest.hash), ("structure", structure or "fixed")]
    return Section(
        "provenance", "Where it comes from", [Table("Model", ("what", "value"), facts), version_table(versions)]
    )


def version_table(text: str) -> Table:
    """Return a table of package versions from their JSON."""
    return Table("Versions", ("package", "version"), list(json.loads(text).items()))
