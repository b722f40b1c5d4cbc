# SPDX-License-Identifier: Apache-2.0
"""`mehvar simulate`: one run from the command line, its summary, file and picture."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from mehvar.base.errors import InputError, Origin, bad_value, run_checks, unknown_name
from mehvar.base.manifest import OPEN_LOOP, Manifest
from mehvar.pictures.files import checked_suffix
from mehvar.runtime.files import check_file
from mehvar.runtime.model.catalogue import find_model
from mehvar.runtime.model.parameters import check_values, number
from mehvar.runtime.run.formats import checked_format
from mehvar.runtime.run.metrics import deviations_of, grouped_notes, metrics
from mehvar.runtime.run.options import OPTIONS, split_settings
from mehvar.runtime.run.results import notes_of
from mehvar.runtime.run.simulate import Run
from mehvar.runtime.run.simulate import simulate as simulate_run
from mehvar.runtime.run.user.choice import law_of
from mehvar.runtime.run.user.files import read_inputs
from mehvar.runtime.run.user.inputs import Interpolation
from mehvar.runtime.units import read_value
from mehvar.settings import (
    AsJson,
    EndTime,
    Scenario,
    SettingTexts,
    check_names,
    complete_controllers,
    complete_inputs,
    complete_models,
    end_time,
    read_settings,
    read_values,
    required_law,
    whole_number,
)
from mehvar.terminal import print_json, print_table, progress


def command(
    model: Annotated[
        str | None,
        typer.Argument(metavar="MODEL", help="A model or a generated folder.", autocompletion=complete_models),
    ] = None,
    controller: Annotated[
        str | None,
        typer.Option(metavar="C", help="The control law; none for an open loop.", autocompletion=complete_controllers),
    ] = None,
    scenario: Scenario = None,
    settings: SettingTexts = None,
    input_texts: Annotated[
        list[str] | None,
        typer.Option(
            "--input",
            metavar="NAME=VALUE",
            help="An input of an open loop; default: zero; repeat as needed.",
            autocompletion=complete_inputs,
        ),
    ] = None,
    inputs: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Inputs of an open loop over time: a .csv, or a result's .nc.")
    ] = None,
    interpolation: Annotated[
        Interpolation | None,
        typer.Option(metavar="HOW", help="Interpolation of --inputs: hold or linear; default: hold."),
    ] = None,
    t_end: EndTime = None,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE.nc", help="Save the result; also .csv, .parquet, .arrow, .mat.")
    ] = None,
    plot: Annotated[Path | None, typer.Option(metavar="FILE.png", help="Save a picture of the run.")] = None,
    store: Annotated[
        Path | None, typer.Option("--from", metavar="STORE", help="Repeat a run of this batch; needs --run.")
    ] = None,
    run: Annotated[
        int | None, typer.Option(parser=whole_number, metavar="ID", help="Number of the run, counted from 0.")
    ] = None,
    trust_model: Annotated[
        bool, typer.Option("--trust-model", help="With --from: compile and run the model that the store names.")
    ] = False,
    as_json: AsJson = False,
) -> int:
    """Run, or repeat a run of a batch; return the exit status."""
    if store is not None or run is not None or trust_model:
        decided = (controller, scenario, settings, t_end, input_texts, inputs, interpolation)
        if store is None or run is None or any(value is not None for value in decided):
            raise typer.BadParameter(
                "--from STORE needs --run ID; leave out law, scenario and settings, which the batch determines"
            )
        if model is not None and trust_model:
            raise typer.BadParameter("--trust-model takes the model that the store names: leave MODEL out")
        if as_json:
            raise typer.BadParameter("--json cannot be used with --from, which compares a run with its batch")
        return repeat(store, run, out, plot, model, trust_model)
    if model is None:
        raise typer.BadParameter("MODEL and --controller C are needed, or --from STORE and --run ID")
    _check(find_model(model), controller, scenario, settings, t_end, out, plot)
    assert controller is not None
    values = read_values(settings, find_model(model)) | end_time(t_end)
    opened = _open_loop(model, controller, input_texts, inputs, interpolation)
    source = "--input" if inputs is None else f"--inputs {inputs}"
    _check_inputs(find_model(model), scenario, values, opened, source)
    origin = Origin("--set", {"inputs": source} | ({} if t_end is None else {"t_end": "--t-end"}))
    return simulate(model, None if opened else controller, scenario, values, out, plot, opened, as_json, origin)


def _check(
    manifest: Manifest,
    controller: str | None,
    scenario: str | None,
    texts: Sequence[str] | None,
    t_end: str | None,
    out: Path | None,
    plot: Path | None,
) -> None:
    """Report all errors that can be found before a run in one message."""

    def check_settings() -> None:
        values = read_values(texts, manifest)
        if t_end is not None and "t_end" in values:
            raise InputError("t_end is given twice: by --t-end and by --set")
        parameters, _ = split_settings(values, manifest.choices, "run", "--set")
        if law := manifest.controllers.get(controller or ""):
            check_values(manifest, law, parameters, "--set", (*OPTIONS, *manifest.choices))
        else:
            check_names(parameters, manifest)

    run_checks(
        lambda: controller == OPEN_LOOP or manifest.controller(required_law(manifest, controller)),
        lambda: manifest.scenario(scenario),
        check_settings,
        lambda: end_time(t_end),
        lambda: _check_outputs(out, plot),
    )


def _open_loop(
    model: str,
    controller: str,
    texts: Sequence[str] | None,
    file: Path | None,
    interpolation: Interpolation | None,
) -> dict[str, Any]:
    """Return the arguments of an open loop for `simulate`; none for a closed loop."""
    if controller != OPEN_LOOP:
        for flag, value in (("--input", texts), ("--inputs", file), ("--interpolation", interpolation)):
            if value is not None:
                raise bad_value(flag, value, f"left out unless --controller is {OPEN_LOOP}")
        return {}
    if interpolation is not None and file is None:
        raise bad_value("--interpolation", interpolation, "left out without --inputs FILE")
    manifest = find_model(model)
    inputs: Any = {} if file is None else read_inputs(file, manifest)
    given, units = read_settings(texts, "--input"), {q.name: q.unit for q in manifest.inputs}
    constants = {
        name: number(f"--input {name}", read_value(text, units.get(name), name, "--input"))
        for name, text in given.items()
    }
    if constants and not isinstance(inputs, dict):
        raise bad_value("--input", " ".join(constants), f"left out with --inputs {file}, a result that has every input")
    for name in constants:
        if name not in units:
            raise unknown_name(f"input of {manifest.model}", name, units, "--input")
        if name in inputs:
            raise bad_value("--input", name, f"an input that {file} does not have")
    return {"inputs": {**inputs, **constants} if isinstance(inputs, dict) else inputs, "interpolation": interpolation}


def _check_inputs(
    manifest: Manifest, scenario: str | None, values: Mapping[str, Any], opened: Mapping[str, Any], origin: str
) -> None:
    """Refuse invalid inputs with a message that names --input instead of --set."""
    if opened:
        end = values.get("t_end") or manifest.scenario(scenario).duration
        law_of(manifest, None, **opened, period=None, memory=None, end=end, origin=origin)


def simulate(
    model: str,
    controller: str | None,
    scenario: str | None,
    settings: Mapping[str, float | str],
    out: Path | None,
    plot: Path | None,
    opened: Mapping[str, Any],
    as_json: bool = False,
    origin: str = "--set",
) -> int:
    """Run, print and save; return the exit status.

    Raises
    ------
    InputError
        If an argument is unknown, malformed or out of bounds, or a file cannot be written, which is tested before the
        run.
    """
    parameters, options = split_settings(settings, find_model(model).choices, "run", origin)
    with progress(f"{model} {controller or OPEN_LOOP}") as advance:
        advance(0, 1, "(the first run compiles)")
        run = simulate_run(
            model, controller, scenario, parameters, progress=advance, origin=origin, **options, **opened
        )
    return _finish(run, out, plot, as_json, as_described=not settings)


def repeat(
    path: Path, number: int, out: Path | None, plot: Path | None, model: str | None = None, trust: bool = False
) -> int:
    """Repeat one run of a batch with all variables recorded, and report any difference from the batch.

    Raises
    ------
    InputError
        If the store is invalid, the run does not exist or had invalid values, or the model is not available.
    """
    from mehvar.runtime.batch.repeat import difference, is_model_of, plan_of, repeat_run
    from mehvar.runtime.batch.store.store import open_store

    _check_outputs(out, plot)
    store = open_store(path)
    plan = plan_of(store, model, trust)
    if not is_model_of(store, plan.model):
        typer.echo(f"note: {path} was made from another version of the model {store.attributes['model']}")
    with progress(f"{plan.model.name} run {number}") as advance:
        run = repeat_run(plan, store, number, advance)
    what = f"run {number} of {path}"
    drawn = ", ".join(f"{name} = {value!r}" for name, value in plan.drawn(number).items())
    typer.echo(f"{what}: {drawn}" if drawn else what)
    different = difference(run, plan, store, number)
    if different is None:
        typer.echo("this run is not stored yet: there is nothing to compare with")
    else:
        typer.echo(different or "the same as in the store, bit for bit")
    return _finish(run, out, plot) or int(bool(different))


def _check_outputs(out: Path | None, plot: Path | None) -> None:
    for path in (out, plot):
        if path is not None:
            check_file(path)
    if out is not None:
        checked_format(out)
    if plot is not None:
        checked_suffix(plot)


def _finish(run: Run, out: Path | None, plot: Path | None, as_json: bool = False, as_described: bool = False) -> int:
    """Print and save a run. If its scenario is unchanged, compare its metrics with the expected ones."""
    notes = [
        *run.advice,
        *run.stiffness(),
        *run.exceeded(),
        *grouped_notes(notes_of(run)),
        *(_unexpected(run) if as_described else ()),
    ]
    if as_json:
        print_json(_facts(run, notes))
    else:
        _summary(run, notes)
    _save(run, out, plot, as_json)
    if not run.status.complete:
        typer.echo(f"mehvar: the run ended early: {run.reason}", err=True)
        return 3
    return 0


def _summary(run: Run, notes: Sequence[str]) -> None:
    """Print the end of a run, its notes, metrics and events, and a note if Python ran it instead of C."""
    law, case = run.controller.name, run.scenario.name
    typer.echo(f"{run.manifest.model} {law} {case}: {run.reason}, t = {run.t_stop:g} s, {run.run_seconds * 1e3:.1f} ms")
    for text in notes:
        typer.echo(f"note: {text}")
    if run.controller.name == OPEN_LOOP and run.hold is None:
        typer.echo("run by the generated Python module; inputs are evaluated at every stage of a step")
    elif run.backend == "python":
        typer.echo("run by the generated Python module; with a C compiler it is much faster (mehvar doctor)")
    rows = [
        [name, f"{value:.6g}", run.manifest.metrics[name].unit, run.manifest.metrics[name].description]
        for name, value in metrics(run, run.manifest).items()
    ]
    print_table("", ["metric", "value", "unit", "meaning"], rows)
    _print_events(run)


def _print_events(run: Run) -> None:
    """Print the number of occurrences of each event, with the first and the last time."""
    times: dict[str, list[float]] = {}
    for t, name in run.events:
        times.setdefault(name, []).append(t)
    if times:
        rows = [[name, str(len(t)), f"{t[0]:.6g}", f"{t[-1]:.6g}"] for name, t in times.items()]
        print_table("", ["event", "number", "first, s", "last, s"], rows)


def _unexpected(run: Run) -> list[str]:
    """Report metrics that differ from the scenario's expected values, with the tolerances of the papers' report."""
    if run.controller.name not in run.scenario.expect:
        return []
    numbers = deviations_of(run.manifest, run.scenario, run.controller.name, metrics(run, run.manifest))
    return [
        f"the scenario {d.scenario} expects {d.metric.name} = {d.expected:.6g}, not {d.measured:.6g}"
        for d in numbers
        if not d.holds
    ]


def _facts(run: Run, notes: Sequence[str]) -> dict[str, object]:
    """Return the results of a run for `--json`; the key "events" is absent if law and model have none."""
    values = metrics(run, run.manifest)
    return {
        "model": run.manifest.model,
        "controller": run.controller.name,
        "scenario": run.scenario.name,
        "status": run.status.text,
        "reason": run.reason,
        "t_stop": run.t_stop,
        "run_seconds": run.run_seconds,
        "backend": run.backend,
        "method": run.method,
        "checksum": run.checksum,
        "notes": list(notes),
        **({"events": run.events} if run.possible_events else {}),
        "metrics": {n: {"value": float(v), "unit": run.manifest.metrics[n].unit} for n, v in values.items()},
    }


def _save(run: Run, out: Path | None, plot: Path | None, quiet: bool) -> None:
    """Write result file and picture; with `quiet`, stdout belongs to the JSON, and messages go to stderr."""
    if out is None and plot is None:
        return
    from mehvar.runtime.run.formats import save
    from mehvar.runtime.run.results import to_dataset

    dataset = to_dataset(run)
    if out is not None:
        save(dataset, out)
        typer.echo(f"saved {out}", err=quiet)
    if plot is not None:
        from mehvar.pictures.files import save as save_picture
        from mehvar.reproduction.paper import run_picture

        save_picture(run_picture(dataset, run.manifest), plot)
        typer.echo(f"saved {plot}", err=quiet)
