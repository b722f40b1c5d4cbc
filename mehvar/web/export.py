# SPDX-License-Identifier: Apache-2.0
"""Export of a model as one HTML page that simulates it without a network."""

from __future__ import annotations

import base64
import gzip
import os
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from mehvar import html
from mehvar.base.capabilities import Operation, refuse
from mehvar.base.manifest import Controller, Manifest, Metric, Parameter, Quantity, Shape
from mehvar.base.schema import plain
from mehvar.runtime.arguments import check_arguments
from mehvar.runtime.batch.evaluation.conditions import Criterion
from mehvar.runtime.files import check_folder, filling
from mehvar.runtime.model.functions import FloatArray
from mehvar.runtime.model.model import Model, load
from mehvar.runtime.run.options import RunOptions
from mehvar.runtime.run.problem import Status

from .cases import Case, cases_of
from .failure import Failure, criterion_of, failure_of
from .module import compiled_module, zig_toolchain

_UPLOT = "report/uplot"
_FLAT = 20
"""Ratio of the largest values of two quantities at which the smaller one is flat in a chart of both: a few pixels."""


def export_web(
    model: Model | str | os.PathLike[str],
    out: str | os.PathLike[str],
    *,
    success: str | None = None,
    own_law: str | None = None,
) -> Path:
    """Write a page that simulates a model, with sliders, plots, animation, and a checksum of all numbers.

    Parameters
    ----------
    model : Model, str or path
        A loaded or built model, a name or a generated folder.
    out : path
        Folder of the page `MODEL.html`.
    success : str, optional
        A condition on metrics, as of `batch`; default: reaching the end. The page judges each run by it. If a search
        finds one, the page offers a run that fails and differs in one parameter from a successful run.
    own_law : str, optional
        Initial text of the page's field for the reader's law: a line `INPUT = EXPRESSION` for each input; default: all
        are zero.

    Returns
    -------
    Path
        The page.

    Raises
    ------
    InputError
        If the model is unknown, no law runs a scenario, or `success` is no condition on its metrics; or if `out` cannot
        be a folder or has another page of that name.
    MissingError
        Without zig; the message says how to install it.
    BuildError
        If compilation fails.
    OSError
        If the page cannot be written.
    """
    check_arguments("path", "the call", out=out)
    check_arguments("text", "the call", success=success, own_law=own_law)
    check_folder(out)
    loaded = model if isinstance(model, Model) else load(model)
    refuse(loaded.manifest, Operation.PAGE)
    criterion = criterion_of(loaded.manifest, success)
    zig_toolchain()  # before the runs, which take longer
    name, maker = f"{loaded.manifest.model}.html", f"mehvar export web {loaded.manifest.model}"
    check_folder(out, maker, [name])
    cases = cases_of(loaded)
    text = web_page(loaded.manifest, cases, criterion, failure_of(loaded, cases, criterion), own_law)
    with filling(out, maker) as folder:
        (folder / name).write_text(text, encoding="utf-8")
    return Path(out) / name


def web_page(
    manifest: Manifest,
    cases: Sequence[Case],
    criterion: Criterion | None = None,
    failure: Failure | None = None,
    own_law: str | None = None,
) -> str:
    """Return the page of a model with some runs."""
    drawing = tuple(f"report/{name}.js" for name in ("data", "save", "charts", "view", "geometry"))
    names = (f"{_UPLOT}/uPlot.iife.min.js", *drawing, "web/simulator.js")
    names += ("web/metrics.js", "web/motion.js", "web/formulas.js", "web/live.js")
    return html.page(
        "web/live.html.j2",
        title=f"{manifest.model}: {manifest.title}",
        styles=[
            html.asset(name) for name in (f"{_UPLOT}/uPlot.min.css", "palette.css", "report/charts.css", "web/live.css")
        ],
        scripts=[html.asset(name) for name in names],
        runs=[{"law": case.run.controller.name, "scenario": case.run.scenario.name} for case in cases],
        moves=bool(manifest.geometry),
        judged=criterion is not None,
        measured=bool(manifest.metrics),
        first=cases[0].run.scenario.name,
        failure=failure,
        own_law=own_law or "\n".join(f"{q.name} = 0" for q in manifest.inputs),
        licence=html.asset(f"{_UPLOT}/LICENSE"),
        data=html.script_data(page_data(manifest, cases, criterion, failure)),
    )


def page_data(
    manifest: Manifest, cases: Sequence[Case], criterion: Criterion | None = None, failure: Failure | None = None
) -> dict[str, Any]:
    """Return the data for simulator.js and live.js: module, names of the model, runs."""
    options = RunOptions()
    ticks = list({case.t.tobytes(): case.t for case in cases}.values())
    return {
        "name": manifest.model,
        "states": _by_size(manifest.states, [case.run.x for case in cases]),
        "inputs": _by_size(manifest.inputs, [case.run.u for case in cases]),
        "outputs": _quantities(manifest.outputs),
        "seen": [q.name for q in manifest.seen],
        "references": [q.name for q in manifest.references],
        "widths": {
            "x": len(manifest.states),
            "u": len(manifest.inputs),
            "u_cmd": len(manifest.inputs),
            "y": len(manifest.outputs),
        },
        "parameters": _parameters(manifest.parameters),
        "scenario_parameters": _parameters(manifest.scenario_parameters),
        "laws": {law.name: _law(law) for law in manifest.controllers.values()},
        "limits": manifest.limits,
        "constraints": manifest.constraints,
        "statuses": {status: status.text for status in Status},
        "metrics": [plain(Metric, metric) for metric in manifest.metrics.values()],
        "success": None if criterion is None else {"text": criterion.text, "condition": criterion.nested()},
        "noise": len(manifest.noise),
        "shapes": [plain(Shape, shape) for shape in manifest.geometry],
        "seed": options.seed,
        "max_steps": options.max_steps,
        "rtol": options.rtol,
        "atol": options.atol,
        "cases": [_case(case, ticks) for case in cases],
        "failure": None if failure is None else asdict(failure),
        "ticks": [_packed(t.astype("<f8").tobytes()) for t in ticks],
        "module": _packed(compiled_module(manifest, cases)),
    }


def _case(case: Case, ticks: Sequence[FloatArray]) -> dict[str, Any]:
    """Return a case for the page's script; "ticks" is the position of its instants in `ticks`."""
    run = case.run
    return {
        "law": run.controller.name,
        "scenario": run.scenario.name,
        "p": run.parameters.p.tolist(),
        "c": run.parameters.c.tolist(),
        "s": run.parameters.s.tolist(),
        "formulas": case.formulas,
        "ticks": next(place for place, t in enumerate(ticks) if np.array_equal(t, case.t)),
        "record_every": case.record_every,
        "hold_every": case.hold_every,
        "end": float(case.t[-1]),
        "checksum": run.checksum,
    }


def _law(law: Controller) -> dict[str, Any]:
    return {
        "parameters": _parameters(law.parameters),
        "memory": [q.name for q in law.memory],
        "constraints": law.constraints,
        "fixed": [
            name for name in (law.period, law.delay) if name
        ],  # they decide the instants, which are not computed here
    }


def _quantities(quantities: Sequence[Quantity]) -> list[dict[str, str]]:
    return [plain(Quantity, q) for q in quantities]


def _by_size(quantities: Sequence[Quantity], series: Sequence[FloatArray]) -> list[dict[str, Any]]:
    """Return quantities with the number of their chart among those of their unit, by the largest value of all runs."""
    largest = np.nanmax(np.abs(np.concatenate(series)), axis=0, initial=0.0)
    charts, first, last = np.zeros(len(quantities), np.int64), dict[str, float](), dict[str, int]()
    for k in np.argsort(largest, kind="stable"):
        unit = quantities[k].unit
        if largest[k] > _FLAT * first.setdefault(unit, largest[k]) > 0:
            first[unit], last[unit] = largest[k], last.get(unit, 0) + 1
        charts[k], first[unit] = last.get(unit, 0), first[unit] or largest[k]
    return [q | {"chart": chart} for q, chart in zip(_quantities(quantities), charts.tolist(), strict=True)]


def _parameters(parameters: Sequence[Parameter]) -> list[dict[str, Any]]:
    """Return parameters for the page's script; an infinite bound is None, since JSON has no infinity."""
    return [plain(Parameter, q) | {"interval": q.interval} for q in parameters]


def _packed(content: bytes) -> str:
    """Return bytes compressed and as base64; equal bytes give equal results."""
    return base64.b64encode(gzip.compress(content, mtime=0)).decode("ascii")
