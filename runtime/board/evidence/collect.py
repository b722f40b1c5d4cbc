# SPDX-License-Identifier: Apache-2.0
"""Collection of all evidence about a law in an image for an emulated board."""

from __future__ import annotations

import hashlib
from bisect import bisect_right
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mehvar.base.errors import MehvarError

from ...model.model import Model
from ..emulator.profile import STEP, line_table
from ..image.instructions import UnboundedError
from ..line.link import Link
from ..run import BoardRequest, BoardRun, run_on_board
from ..targets import MachinePort
from .branches import Condition, Outcomes
from .flow import Flow
from .trace import Traced, trace


class EvidenceError(MehvarError, RuntimeError):
    """Error for incomplete evidence about an image; no page is written."""


_ODD = (0.0, -0.0, 1e-40, 1e-20, 1e31, -3e38, np.inf, -np.inf, np.nan)
"""Values of a broken sensor or line: signed zeros, subnormal, too large, infinite, NaN."""
_SCALES = (-3.0, 3.0)
"""Powers of ten by which memory and measurements are scaled, as estimates may be wrong by a factor of a thousand."""


@dataclass(frozen=True)
class Length:
    """Number of instructions of a function with all functions that it calls.

    Attributes
    ----------
    bound : int or None
        Largest number of instructions of a call, derived from the image; None if unknown.
    reason : str
        Reason why it is unknown.
    seen : int
        Largest number observed in the campaign.
    """

    function: str
    bound: int | None
    reason: str
    seen: int


@dataclass(frozen=True)
class Reached:
    """Executed instructions of a function."""

    function: str
    instructions: int
    run: int


@dataclass(frozen=True)
class Evidence:
    """Evidence about a law in an image.

    Attributes
    ----------
    run : BoardRun
        The closed loop, compared with the same law on this machine.
    disturbed : int
        Further steps of the campaign, from drawn memories, parameters and measurements.
    traced : list of Traced
        The steps of the law.
    lengths, reached, conditions
        Results for a sample's evaluation and each function that it calls.
    addresses : set of int
        Instructions that ran in the campaign.
    lines : mapping of int to (str, int)
        File and line of each condition's address.
    """

    run: BoardRun
    disturbed: int
    sha256: str
    traced: list[Traced]
    lengths: list[Length]
    reached: list[Reached]
    conditions: list[Condition]
    addresses: set[int]
    lines: Mapping[int, tuple[str, int]]


def collect(
    model: Model,
    controller: str,
    board: str | None = None,
    compiler: str | None = None,
    samples: int = 200,
    disturbed: int = 400,
) -> Evidence:
    """Compile a law for an emulated board, run and disturb it, and return the evidence.

    Parameters
    ----------
    samples : int
        Samples of the closed loop.
    disturbed : int
        Steps from drawn memories, parameters and measurements.

    Raises
    ------
    InputError
        For unknown names.
    """
    run = run_on_board(model, BoardRequest(controller, "unicorn", board, compiler, samples=samples))
    assert run.elf is not None
    flow = Flow(run.elf)
    names = [STEP, *sorted(flow.callees(STEP) - {STEP})]
    outcomes = _campaign(model, run, names, disturbed)
    _check(outcomes, names, run)
    rows = line_table(run.image.path)
    starts = [address for address, _, _ in rows]
    places = {c.address: rows[bisect_right(starts, c.address) - 1][1:] for c in outcomes.conditions}
    reached = [
        Reached(name, len(text), sum(i.address in outcomes.addresses for i in text))
        for name, text in outcomes.instructions.items()
    ]
    return Evidence(
        run, disturbed, hashlib.sha256(run.image.path.read_bytes()).hexdigest(),
        trace(model, controller, run.elf, run.image.path), [_length(flow, name, outcomes) for name in names], reached,
        outcomes.conditions, outcomes.addresses, places,
    )  # fmt: skip


def _check(outcomes: Outcomes, names: list[str], run: BoardRun) -> None:
    """Refuse evidence in which a function was not executed, or the closed loop's longest step is missing."""
    missing = sorted(outcomes.most.keys() - names)
    if missing:
        raise EvidenceError(f"the analysis of the code found no call to {', '.join(missing)}, which a step executes")
    most, seen = run.profile.most if run.profile else 0, outcomes.most.get(STEP, 0)
    if seen < most:
        raise EvidenceError(
            f"the longest step of the campaign has {seen} instructions, fewer than the {most} in the closed loop"
        )


def _length(flow: Flow, name: str, outcomes: Outcomes) -> Length:
    seen = outcomes.most.get(name, 0)
    try:
        return Length(name, flow.worst(name), "", seen)
    except UnboundedError as error:
        return Length(name, None, str(error), seen)


def _campaign(model: Model, run: BoardRun, names: list[str], disturbed: int) -> Outcomes:
    """Return the outcomes of conditions in the run's samples and in disturbed steps, with a fixed seed."""
    port = MachinePort(run.image)
    link = Link(port, run.image.program.layout)
    link.connect()
    assert run.elf is not None
    outcomes = Outcomes(port.machine, run.elf, names)
    rng = np.random.default_rng(1)
    _start(link, run)
    for k in range(len(run.single.t)):
        link.step(_numbers(model, run, k).astype(np.float32))
    for j in range(disturbed):
        if j % 10 == 0:
            _start(link, run)
            link.set("c", _drawn_parameters(run, rng))
        k = int(rng.integers(len(run.single.t)))
        if run.image.program.layout.memory:
            link.set("z", _stretched(rng, run.single.z[k]).astype(np.float32))
        with np.errstate(over="ignore"):
            link.step(_broken(rng, _stretched(rng, _numbers(model, run, k))).astype(np.float32))
    return outcomes


def _start(link: Link, run: BoardRun) -> None:
    link.reset()
    resolved = run.single.parameters
    for group, values in zip("pcs", (resolved.p, resolved.c, resolved.s), strict=True):
        link.set(group, values)
    link.set("z", run.single.z[0])


def _numbers(model: Model, run: BoardRun, k: int) -> NDArray[np.float64]:
    """Return the numbers sent to the board at a sample."""
    single = run.single
    r = model.functions["reference"](single.t[k], single.parameters.p, single.parameters.s)
    applied = single.u[k - 1] if k else np.zeros(single.u.shape[1])
    x = single.x[k]
    if model.manifest.measured:
        x = model.functions["measure"](x, np.zeros(len(model.manifest.noise)), single.parameters.p)
    parts = [x, r, applied] if run.image.program.layout.memory else [x, r]
    return np.concatenate(parts)


def _stretched(rng: np.random.Generator, values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return numbers with a random selection scaled up or down."""
    which = rng.random(values.size) < rng.choice([0.0, 0.05, 0.3])
    return np.where(which, values * 10 ** rng.uniform(*_SCALES, values.size), values)


def _broken(rng: np.random.Generator, values: NDArray[np.float64]) -> NDArray[np.float64]:
    values = values.copy()
    if rng.random() < 0.5:
        values[rng.integers(values.size)] = rng.choice(_ODD)
    return values


def _drawn_parameters(run: BoardRun, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return the law's parameters with some at their bounds."""
    values = run.single.parameters.c.copy()
    for i, parameter in enumerate(run.image.program.law.parameters):
        ends = [end for end in (parameter.lower, parameter.upper) if np.isfinite(end)]
        ends = [end for end in ends if parameter.allows(end)]
        if ends and rng.random() < 0.3:
            values[i] = rng.choice(ends)
    return values
