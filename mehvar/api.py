# SPDX-License-Identifier: Apache-2.0
"""Python interface: the functions for users, with results as xarray datasets."""

from __future__ import annotations

import inspect
import os
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from mehvar.base.errors import InputError, bad_value
from mehvar.formats.ephemeris import MESSAGES, read_message
from mehvar.runtime.arguments import check_arguments
from mehvar.runtime.batch.dispersions import in_units
from mehvar.runtime.batch.fill import BatchProgress, run_batch
from mehvar.runtime.batch.plan import Campaign
from mehvar.runtime.batch.points import columns_of, count, grid, lists_as_distributions
from mehvar.runtime.batch.repeat import SESSION_LAWS, keep_for_session
from mehvar.runtime.batch.store.store import Store, open_store
from mehvar.runtime.compiling.library import begin_native
from mehvar.runtime.interrupts import KeptInterrupts
from mehvar.runtime.model.catalogue import find_model
from mehvar.runtime.model.model import Model, load
from mehvar.runtime.model.parameters import all_parameters, elements
from mehvar.runtime.run.formats import open_result as open_file
from mehvar.runtime.run.options import merged, split_settings
from mehvar.runtime.run.results import to_dataset
from mehvar.runtime.run.simulate import simulate as simulate_run
from mehvar.runtime.run.user.choice import law_of
from mehvar.runtime.units import setting_units
from mehvar.terminal import BatchMeter, cell_progress, progress

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from distributed import Client

    from mehvar.models.parts import Spacecraft
    from mehvar.models.system import System
    from mehvar.runtime.batch.points import GivenDesign
    from mehvar.runtime.batch.sampling import Design
    from mehvar.runtime.model.functions import BackendName
    from mehvar.runtime.run.user.inputs import Interpolation
    from mehvar.runtime.run.user.law import LawFunction, PythonLaw


def build(system: System | Spacecraft | Callable[[], System], backend: BackendName | None = None) -> Model:
    """Generate a system defined in Python, and load it. Results are cached.

    Parameters
    ----------
    system : System, Spacecraft or callable
        The system, or a function that returns it. Branches on symbols in the function, such as `min(p, 1)`, are
        refused with file and line.
    backend : {"c", "python"}, optional
        As of `mehvar.load`.

    Raises
    ------
    ModelError
        If its parts do not fit together.
    """
    from mehvar.codegen.build import built_folder

    if not (isinstance(backend, str) and backend == "python"):
        begin_native()  # seconds of a first start, beside those of the derivation
    with progress(f"deriving {getattr(system, 'name', 'a system')}"):
        folder = built_folder(system)
    return load(folder, backend)


def simulate(
    model: Model | str | os.PathLike[str],
    controller: str | LawFunction | None,
    scenario: str | None = None,
    parameters: Mapping[str, ArrayLike] | None = None,
    initial: Mapping[str, float] | None = None,
    *,
    inputs: Mapping[str, Any] | xr.Dataset | None = None,
    interpolation: Interpolation | None = None,
    period: float | None = None,
    memory: ArrayLike | None = None,
    **options: Any,
) -> xr.Dataset:
    """Simulate one run: closed with a law of the model, closed with your own Python law, or open.

    Parameters
    ----------
    model : str, path or Model
        Name of a model, a generated folder, or a loaded model.
    controller : str or callable
        A law of the model by name; or a function law(t, x) -> u, or law(t, x, z) -> (u, z_next) with `memory`. `x` is
        an array with named elements, as in `x.roll`, and named references. If the model has a sensor and `period` is
        given, `x` is the measurement. None for an open loop.
    scenario : str, optional
        Default: the model's first scenario.
    parameters : mapping, optional
        Values of plant, law and scenario parameters by name; an array for a vector or a matrix of parameters.
    initial : mapping, optional
        Initial states that differ from the scenario's.
    inputs : mapping or xarray.Dataset, optional
        For an open loop: inputs by name, each a number, a pair (t, values) of arrays or a function of t; default:
        zero. Or the result of an earlier run, whose commands are repeated.
    interpolation : {"hold", "linear"}, optional
        Interpolation of arrays between their instants; default: "hold".
    period : float, optional
        Time in s between evaluations of a Python law or input, whose result is held in between. Without it the
        function is continuous and is evaluated at every stage of a step.
    memory : array_like, optional
        Initial memory of a Python law.
    **options
        Options of the run, as in `t_end=5.0` (`mehvar simulate` has a table of them), choices of the model, as in
        `plant="reduced"`, parameters by name, as in `disturbance=0.001`, and `progress`, `law` and `origin` as in
        `mehvar.runtime.simulate`.

    Returns
    -------
    xarray.Dataset
        Coordinate `t`; one variable per state, input `u_NAME` and output, with units. A run that ends early returns its
        data with `status`, `reason` and `t_stop` in attrs.

    Raises
    ------
    InputError
        If a name is unknown, a value is out of bounds, or a start is infeasible.
    LawError
        If a function fails, or returns an invalid input; the message has the instant and the value.
    """
    with cell_progress("simulating") as advance:
        run = simulate_run(
            model,
            controller,
            scenario,
            parameters,
            initial,
            inputs=inputs,
            interpolation=interpolation,
            period=period,
            memory=memory,
            **{"progress": advance, **options},
        )
    return to_dataset(run)


def batch(
    model: Model | str | os.PathLike[str],
    controller: str | LawFunction | None = None,
    n: int | None = None,
    scenario: str | None = None,
    parameters: Mapping[str, ArrayLike] | None = None,
    initial: Mapping[str, float] | None = None,
    *,
    inputs: Mapping[str, Any] | xr.Dataset | None = None,
    interpolation: Interpolation | None = None,
    period: float | None = None,
    memory: ArrayLike | None = None,
    vary: Mapping[str, str | Sequence[float]] | None = None,
    points: pd.DataFrame | Mapping[str, ArrayLike] | str | os.PathLike[str] | None = None,
    design: GivenDesign | None = None,
    seed: int | None = None,
    sampling: Design | None = None,
    save: float | None = None,
    out: str | os.PathLike[str] | None = None,
    resume: bool = False,
    success: str | None = None,
    until: str | None = None,
    require: Mapping[str, str] | None = None,
    confidence: float | None = None,
    strict: bool = False,
    threads: int | None = None,
    scheduler: str | Client | None = None,
    report: BatchProgress | None = None,
    **options: Any,
) -> xr.Dataset:
    """Simulate many closed loops.

    Parameters
    ----------
    model : str, path or Model
        Name of a model, a generated folder, a loaded model, or a campaign file that ends in `.toml`; besides such a
        file only `out` and what follows it may be given.
    controller, n : str or callable, int
        The law, and the number of runs. A function as in `simulate` is called once a period for a block of runs, with
        `x` of shape (nx, runs) and memory (nz, runs), and returns inputs (nu, runs). The same function works in both
        if it computes with NumPy and branches by `numpy.where`. A run ends when its input is not finite.
    scenario : str, optional
        Default: the model's first scenario.
    parameters, initial : mapping, optional
        Parameters and initial states that all runs share.
    inputs, interpolation, period, memory
        As in `simulate`; the same in all runs. Inputs that are not held need a period.
    vary : mapping of str to str or sequence of float, optional
        Distributions of parameters or initial states by name, as in `{"m1": "normal(50, 2)"}`, with units as in
        `"uniform(10 deg, 20 deg)"`. Or a sequence of values, one per run, whose length is the number of runs.
    points : pandas.DataFrame, mapping or path, optional
        Given points: a column per varied name and a row per run; a path names a CSV file.
    design : {"grid"}, optional
        Every combination of the lists of `vary`, the last name fastest.
    seed : int, optional
        Seed of all random numbers; default: 0. Run i of a seed is the same on every machine and with any number of
        threads.
    sampling : str, optional
        Design of the drawn points: "random", "latin", "sobol" or "saltelli"; default: "random".
    save : float, optional
        Store series too, one sample every `save` seconds.
    out : path, optional
        The store, a new folder; default: in memory.
    resume : bool
        Continue the store `out`.
    success, until : str, optional
        Condition for success, as in "T_theta < 20". Condition to stop, as in "ci(success) < 0.01", or "decided" to
        stop when each requirement is decided.
    require, confidence : mapping of str to str, float, optional
        Requirements on all runs by name, and the confidence of their verdicts; see `mehvar.require`.
    strict : bool
        Stop at a run with invalid drawn values, instead of marking it `impossible`.
    threads : int, optional
        Default: all processors.
    scheduler : str or distributed.Client, optional
        A dask cluster that computes the runs.
    report : callable, optional
        Called at the start and after each block with the numbers of stored runs, all runs, and runs that ended early.
    **options
        `t_end`, `dt_out`, `method`, ... and choices as in `simulate`, `profile`, or parameters by name.

    Returns
    -------
    xarray.Dataset
        Dimension `run`: drawn values, metrics, `final`, `minimum`, `maximum`, `t_stop`, `status` and, with `save`,
        series. Values are read from the store when they are used.

    Raises
    ------
    InputError
        If a name is unknown, a value is out of bounds, or a start is infeasible.
    OSError
        If the store cannot be written; `resume=True` continues from its blocks.
    """
    with KeptInterrupts():  # also while the results are read, by a library that has weak references
        return stored_batch(
            model,
            out=out,
            resume=resume,
            success=success,
            until=until,
            require=require,
            confidence=confidence,
            strict=strict,
            threads=threads,
            scheduler=scheduler,
            report=report,
            controller=controller,
            n=n,
            scenario=scenario,
            parameters=parameters,
            initial=initial,
            inputs=inputs,
            interpolation=interpolation,
            period=period,
            memory=memory,
            vary=vary,
            points=points,
            design=design,
            seed=seed,
            sampling=sampling,
            save=save,
            **options,
        ).dataset()


def stored_batch(
    model: Model | str | os.PathLike[str],
    *,
    out: str | os.PathLike[str] | None = None,
    resume: bool = False,
    success: str | None = None,
    until: str | None = None,
    require: Mapping[str, str] | None = None,
    confidence: float | None = None,
    strict: bool = False,
    threads: int | None = None,
    scheduler: str | Client | None = None,
    report: BatchProgress | None = None,
    **posed: Any,
) -> Store:
    """Return the store of a batch; see `batch`. `posed` has the arguments of `posed_batch`."""
    check_arguments("mapping", "the call", require=require)
    source: Model | str | os.PathLike[str]
    if str(model).endswith(".toml"):
        from mehvar.campaign import read_campaign

        check_file_determines(model, posed)
        file, origin, own = read_campaign(Path(str(model))), str(model), None
        campaign, source = file.campaign(origin), file.model
        out = file.out if out is None else out
        success = file.success if success is None else success
        until = file.until if until is None else until
        require = file.require if require is None else require
        confidence = file.confidence if confidence is None else confidence
    else:
        origin, source = "the call", model
        campaign, own = posed_batch(model, **posed)
    with KeptInterrupts(), _connected(scheduler) as client, cell_progress("batch") as advance:
        store = run_batch(
            source,
            campaign,
            out,
            resume=resume,
            success=success,
            until=until,
            require=require,
            confidence=confidence,
            strict=strict,
            threads=threads,
            client=client,
            report=report if report is not None or advance is None else BatchMeter(advance),
            own=own,
            origin=origin,
        )
    if isinstance(source, Model):
        keep_for_session(store, source)
    return store


def check_file_determines(path: object, posed: Mapping[str, Any]) -> None:
    """Refuse arguments of `posed_batch` beside a campaign file, which has their values.

    Raises
    ------
    InputError
        If an argument is given, or is None and none of the function's own.
    """
    own = inspect.signature(posed_batch).parameters
    for name, value in posed.items():
        if value is not None or name not in own:
            raise bad_value(name, value, f"left out: {path} determines the run", "the call")


def posed_batch(
    model: Model | str | os.PathLike[str],
    controller: str | LawFunction | None = None,
    n: int | None = None,
    scenario: str | None = None,
    parameters: Mapping[str, ArrayLike] | None = None,
    initial: Mapping[str, float] | None = None,
    *,
    inputs: Mapping[str, Any] | xr.Dataset | None = None,
    interpolation: Interpolation | None = None,
    period: float | None = None,
    memory: ArrayLike | None = None,
    vary: Mapping[str, str | Sequence[float]] | None = None,
    points: pd.DataFrame | Mapping[str, ArrayLike] | str | os.PathLike[str] | None = None,
    design: GivenDesign | None = None,
    seed: int | None = None,
    sampling: Design | None = None,
    save: float | None = None,
    **options: Any,
) -> tuple[Campaign, PythonLaw | None]:
    """Return the campaign of a batch and its Python law, if any; see `batch`."""
    origin = "the call"
    check_arguments("text", origin, scenario=scenario)
    check_arguments("mapping", origin, parameters=parameters, initial=initial, vary=vary)
    manifest = model.manifest if isinstance(model, Model) else find_model(model)
    units = setting_units(manifest) | {q.name: q.unit for q in manifest.states}
    dispersed = in_units(_points(vary or {}, points, design), units, origin)
    n = count(dispersed, origin) if n is None else n
    if (controller is None and inputs is None) or n is None:
        raise InputError("a batch needs n, the number of runs, and a controller or inputs")
    shared, settings = split_settings(options, manifest.choices, "batch", origin)
    case = manifest.scenario(scenario)
    end = settings.get("t_end") or case.duration
    law, own = law_of(manifest, controller, inputs, interpolation, period, memory, end, origin)
    if own is not None and own.text and callable(controller):
        SESSION_LAWS[own.text] = controller
    known = [q.name for q in all_parameters(manifest, law)]
    campaign = Campaign(
        controller=law.name,
        n=n,
        scenario=case.name,
        seed=Campaign.seed if seed is None else seed,
        vary=dispersed,
        parameters=elements(merged(parameters or {}, shared, origin), known, origin),
        initial=dict(initial or {}),
        sampling=Campaign.sampling if sampling is None else sampling,
        options=settings,
        save_every=save,
    )
    return campaign, own


def open_result(path: str | os.PathLike[str]) -> xr.Dataset:
    """Read a complete result file, open the store of a batch, or read a CCSDS message.

    Parameters
    ----------
    path : path
        A `.nc` file from `save` or `mehvar simulate --out`; the folder of a batch, whose values are read on use; an
        orbit in an `.oem` file; or an attitude in an `.aem` file.

    Raises
    ------
    InputError
        If the path does not exist or is none of these.
    """
    if isinstance(path, str | os.PathLike) and os.path.isdir(path):  # noqa: PTH112 - pathlib raises for a name that is too long
        return open_store(path).dataset()
    if isinstance(path, str | os.PathLike) and Path(path).suffix.lower() in MESSAGES:
        return read_message(Path(path))
    return open_file(path)


def _points(vary: Mapping[str, Any], points: Any, design: GivenDesign | None) -> dict[str, str]:
    """Return all dispersions as texts: distributions, lists, grids of lists, and the user's own points."""
    if design is not None and not (isinstance(design, str) and design == "grid"):
        raise bad_value("design", design, '"grid"; for drawn points use sampling', "the call")
    own = {} if points is None else columns_of(points, "the call")
    for name in own.keys() & vary.keys():
        raise InputError(f"{name} is given twice, in vary and in points (from the call)")
    return lists_as_distributions({**(grid(vary, "the call") if design else vary), **own}, "the call")


def _connected(scheduler: str | Client | None) -> AbstractContextManager[Client | None]:
    """Connect to the address of a scheduler; a client that the caller passes stays open afterwards."""
    if not isinstance(scheduler, str):
        return nullcontext(scheduler)
    from mehvar.runtime.batch.workers import connect

    client: AbstractContextManager[Client | None] = connect(scheduler)
    return client
