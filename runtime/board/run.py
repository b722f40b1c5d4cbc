# SPDX-License-Identifier: Apache-2.0
"""Closed loop with a law on a board, compared with the law in float and in double on this machine."""

from __future__ import annotations

import hashlib
import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mehvar.base.errors import InputError

from ..model.functions import Real
from ..model.model import Model
from ..model.parameters import Resolved, resolve
from ..run.options import read_options
from ..run.simulate import Run, simulate
from .emulator.profile import Coverage, Profile, StepProfiler, coverage
from .image.build import Image, build, check_float, delay_of, period_of, program
from .image.elf import Elf, read_elf
from .image.header import Layout
from .image.instructions import UnboundedError
from .image.processors import process_toolchain
from .image.toolchains import board as board_named
from .image.toolchains import toolchain
from .journal import Journal, Tuning
from .line.link import Counters, Hello, Link, Port, SelfTest
from .line.packets import BareLaw
from .session import RESTARTS, BoardLaw
from .stack import StackBound, stack_bound
from .targets import TARGETS, MachinePort, open_target
from .tuning import HostLaw, Request, Requests

_SELF_TEST = 200
"""Number of samples of the self-test. A wrong bit changes the checksum at once; more samples only show slower steps."""


@dataclass(frozen=True)
class BoardRequest:
    """Request of a closed loop with its law on a board.

    Attributes
    ----------
    target : str
        "sil", "unicorn", "qemu" or a serial port.
    board, compiler : str, optional
        Board and compiler of the image; default: "stm32f4", and gcc or else zig. For software in the loop, a
        processor of QEMU's user mode; default: this machine's.
    samples : int
        Number of evaluations of the law; the reference continues past the scenario's end.
    delay : int, optional
        Samples between computing an input and applying it; default: one for a law designed for a delay, else none.
    parameters, options : mapping
        Parameters by name; options and choices of `simulate`.
    every : int, optional
        Samples between two comparisons of the law's memory; default: 1 on a fast line, else 10.
    raw : bool
        Bare packets.
    journal : Path, optional
        File with which a run can continue after a stop of its host.
    selftest : int
        Number of samples of the self-test with law and plant on the target.
    tunable : tuple of str, optional
        Parameters that stay variable while all others become constants of the law's code; default: all.
    restarts : int
        Number of restarts of the board at one sample that ends the run.
    profiled : bool
        Count instructions, if the emulator can; long runs are faster without.
    """

    controller: str
    target: str = "unicorn"
    board: str | None = None
    compiler: str | None = None
    scenario: str | None = None
    samples: int = 600
    delay: int | None = None
    parameters: Mapping[str, object] | None = None
    options: Mapping[str, Any] | None = None
    every: int | None = None
    raw: bool = False
    journal: Path | None = None
    selftest: int = _SELF_TEST
    tunable: tuple[str, ...] | None = None
    restarts: int = RESTARTS
    profiled: bool = True


@dataclass(frozen=True)
class Difference:
    """Difference of two series of floats, in units in the last place and absolute."""

    compared: int
    ulp: int
    size: float
    first: int | None


@dataclass(frozen=True)
class BoardRun:
    """A run on a board with the runs that it is compared with.

    Attributes
    ----------
    board, single, double, undelayed : Run
        The law on the board; in float and in double on this machine; in double and without the delay.
    u, z : Difference
        Board against float on this machine.
    profile : Profile or None
        Counted instructions, if the emulator counts.
    bound : StackBound or None
        Stack bound of the image; None for software in the loop, or if undetermined.
    tunings : tuple of Tuning
        Changes of the law's parameters during the run.
    refused : tuple of Request
        Requests after the last sample, which are refused and not in the journal.
    """

    request: BoardRequest
    image: Image
    elf: Elf | None
    hello: Hello | None
    board: Run
    single: Run
    double: Run
    undelayed: Run | None
    u: Difference
    z: Difference
    x: Difference
    rate: float
    bound: StackBound | None
    counters: Counters | None = None
    stats: Mapping[str, int] = field(default_factory=dict)
    restored: int = 0
    ticks: tuple[int, ...] = ()
    selftest: SelfTest | None = None
    profile: Profile | None = None
    covered: tuple[Coverage, ...] = ()
    tunings: tuple[Tuning, ...] = ()
    refused: tuple[Request, ...] = ()

    @property
    def max_ulp(self) -> int:
        """Largest difference of any input or memory number, in units in the last place."""
        return max(self.u.ulp, self.z.ulp)

    @property
    def same(self) -> bool:
        """True if inputs, memory and states have the same bits on board and host."""
        return self.max_ulp == 0 and self.x.ulp == 0


def build_image(model: Model, request: BoardRequest, resolved: Resolved | None = None) -> Image:
    """Compile the firmware for a run.

    Parameters
    ----------
    resolved : Resolved, optional
        The compiled-in parameters; default: the scenario's.

    Raises
    ------
    InputError
        If board, compiler or law are not known, or a compiler is missing.
    BuildError
        If the compiler fails.
    """
    firmware = program(
        model, request.controller, request.scenario, request.raw, _hold(request), request.tunable, resolved
    )
    if request.target == "sil":
        return build(firmware, None, process_toolchain(request.board, request.compiler))
    return build(firmware, board_named(request.board or "stm32f4"), toolchain(request.compiler))


def run_on_board(model: Model, request: BoardRequest) -> BoardRun:
    """Run a closed loop with its law on a board, and compare it with the law on this machine.

    Raises
    ------
    InputError
        If a name is unknown, a value is out of bounds, or the board runs another program.
    LinkError
        If the board does not answer.
    """
    if request.restarts < 1:
        raise InputError(f"restarts = {request.restarts}: must be a whole number >= 1")
    if request.samples < 2:
        raise InputError(f"samples = {request.samples}: must be a whole number >= 2")
    if request.raw and (request.parameters or request.journal):
        raise InputError(
            "raw: a bare link can neither set parameters nor keep a journal; leave --set and --journal out"
        )
    read_options(request.options or {}, "board", "--set")
    single = _simulate(model, request, real="float")
    check_float(single.parameters)  # those that are not compiled in are set over the line
    image = build_image(model, request, None if request.tunable is None else single.parameters)
    port = open_target(request.target, image)
    try:
        if request.raw:
            return _run_bare(model, request, image, port)
        return _run_framed(model, request, image, port, single)
    finally:
        port.close()


def _run_framed(model: Model, request: BoardRequest, image: Image, port: Port, single: Run) -> BoardRun:
    """Return a run by the framed link, with profile, tuning, self-test and comparisons."""
    layout = image.program.layout
    link = Link(port, layout)
    hello = link.connect()
    elf = _loaded(request, image)
    profiler = None
    if isinstance(port, MachinePort) and elf is not None and request.profiled:
        assert image.board is not None
        profiler = StepProfiler(port.machine, elf, image.board.cpu == "m4f")
    journal, requests = _journal(request, layout, single)
    law = BoardLaw(
        link,
        image.program,
        single.parameters,
        request.every or _every(request.target),
        journal,
        profiler.count if profiler else None,
        requests,
        request.restarts,
    )
    begin, complete = time.perf_counter(), False
    try:
        board = _simulate(model, request, law=law)
        law.finish()
        complete = True
    finally:
        if journal is not None:
            journal.close(complete)
    refused = () if requests is None else requests.close()
    tunings = tuple(journal.tunings) if journal is not None else ()
    if tunings:
        single = _tuned(model, request, image, tunings, "float")
    seconds = time.perf_counter() - begin
    stats = link.stats()
    if profiler:
        profiler.close()
    test = _self_test(link, law, request.selftest)
    stats |= {key: value for key, value in link.stats().items() if key.startswith("stack")}
    z, expected = _memories(law, single)
    covered: tuple[Coverage, ...] = ()
    if profiler and elf:
        laws = (model.manifest.c_name(request.controller), "mv_app_law", "mv_app_step")
        names = [name for name in laws if name in elf.symbols]
        covered = tuple(coverage(image.path, elf, names, profiler.profile.addresses))
    return BoardRun(
        request=request, image=image, elf=elf, hello=hello, board=board, single=single,
        double=_tuned(model, request, image, tunings), undelayed=_undelayed(model, request) if not tunings else None,
        u=difference(np.array(law.u), single.u_cmd[: len(law.u)]), z=difference(z, expected),
        x=difference(board.x, single.x),
        rate=len(law.ticks) / seconds, counters=link.counters, stats=stats, restored=law.restored,
        ticks=tuple(law.ticks), selftest=test, profile=profiler.profile if profiler else None, covered=covered,
        bound=_bound(elf, image), tunings=tunings, refused=refused,
    )  # fmt: skip


def _tuned(model: Model, request: BoardRequest, image: Image, tunings: Sequence[Tuning], real: Real = "double") -> Run:
    """Run the same loop on this machine, with the board's parameter changes."""
    if not tunings:
        return _simulate(model, request, real=real)
    begin = _simulate(model, request, real="float").parameters
    return _simulate(model, request, law=HostLaw(image.program, begin, tunings, real))


def _run_bare(model: Model, request: BoardRequest, image: Image, port: Port) -> BoardRun:
    """Return a run by a line that transfers numbers only, without stats, profile or tuning."""
    law = BareLaw(port, image.program)
    begin = time.perf_counter()
    board = _simulate(model, request, law=law)
    seconds = time.perf_counter() - begin
    single = _simulate(model, request, real="float")
    none = difference(np.empty(0), np.empty(0))
    elf = _loaded(request, image)
    return BoardRun(
        request=request, image=image, elf=elf, hello=None, board=board,
        single=single, double=_simulate(model, request), undelayed=_undelayed(model, request),
        u=difference(np.array(law.u), single.u_cmd), z=none, x=difference(board.x, single.x),
        rate=len(law.u) / seconds, bound=_bound(elf, image),
    )  # fmt: skip


def _loaded(request: BoardRequest, image: Image) -> Elf | None:
    """Return the running image, which is unknown for a board on a serial port."""
    return None if image.board is None or request.target not in TARGETS else read_elf(image.path)


def _bound(elf: Elf | None, image: Image) -> StackBound | None:
    if elf is None or image.board is None:
        return None
    try:
        return stack_bound(elf, image.board.cpu)
    except UnboundedError:
        return None


def _simulate(model: Model, request: BoardRequest, **overrides: Any) -> Run:
    """Run the same loop with the law on this machine."""
    law = model.manifest.controller(request.controller)
    scenario = model.manifest.scenario(request.scenario)
    delay = delay_of(law) if request.delay is None else request.delay
    period = _period(model, request)
    options = {"delay": delay, **(request.options or {}), **overrides, "dt_out": period, "hold": period}
    t_end = (request.samples - 1) * period
    return simulate(
        model, request.controller, scenario.name, request.parameters, t_end=t_end, origin="--set", **options
    )


def samples_of(model: Model, request: BoardRequest) -> int:
    """Return the number of law evaluations in the request's scenario."""
    return 1 + math.floor(model.manifest.scenario(request.scenario).duration / _period(model, request) * (1 + 1e-9))


def _period(model: Model, request: BoardRequest) -> float:
    """Return the law's sample period, s."""
    if hold := _hold(request):
        return hold
    law, scenario = model.manifest.controller(request.controller), model.manifest.scenario(request.scenario)
    resolved = resolve(model.manifest, model.functions, law, scenario, request.parameters or {}, "--set")
    return period_of(law, scenario, resolved)


def _hold(request: BoardRequest) -> float | None:
    """Return the requested sample period, s."""
    hold = (request.options or {}).get("hold")
    return float(hold) if hold else None


def _every(target: str) -> int:
    """Return the number of samples between reads of the memory, each of which doubles a sample's messages.

    Errors in the memory also appear in the inputs of the next sample.
    """
    return 1 if target in ("sil", "unicorn") else 10


def _undelayed(model: Model, request: BoardRequest) -> Run | None:
    delay = (request.options or {}).get("delay", request.delay)
    if delay == 0 or (delay is None and not delay_of(model.manifest.controller(request.controller))):
        return None
    options = {key: value for key, value in (request.options or {}).items() if key != "delay"}
    return _simulate(model, replace(request, delay=0, options=options))


def _self_test(link: Link, law: BoardLaw, samples: int) -> SelfTest | None:
    """Run law and plant on the target from the run's start."""
    if samples <= 0:
        return None
    law.rewind()
    law.prepare()
    return link.selftest(samples)


def _journal(request: BoardRequest, layout: Layout, single: Run) -> tuple[Journal | None, Requests | None]:
    """Open the journal of a run, and the file in which others request parameters."""
    if request.journal is None:
        return None, None
    options = hashlib.sha256(repr(sorted(single.options.items())).encode()).hexdigest()[:16]
    identity = {
        "scenario": single.scenario.name, "options": options, "parameters": dict(single.parameters.values),
        "tunable": request.tunable, "samples": request.samples,
    }  # fmt: skip
    Requests(request.journal)  # refuses a foreign file of that name, before there is a journal
    try:
        journal = Journal(request.journal, identity, layout)
    except OSError as error:
        raise InputError(f"journal = {str(request.journal)!r}: cannot be written ({error.strerror})") from error
    return journal, Requests(request.journal, journal.tunings)


def _memories(law: BoardLaw, single: Run) -> tuple[NDArray[np.float32], NDArray[np.float64]]:
    """Return the board's memory after the compared samples, and the reference values."""
    samples = [k for k in sorted(law.z) if k + 1 < len(single.z)]
    if not samples:
        return np.empty(0, np.float32), np.empty(0)
    return np.stack([law.z[k] for k in samples]), single.z[[k + 1 for k in samples]]


def difference(values: NDArray[Any], expected: NDArray[Any]) -> Difference:
    """Return the differences of two series as floats.

    Parameters
    ----------
    values, expected : array, (n, ...)
        One row per sample; a missing row of `values` is a difference.
    """
    a, b, apart = np.asarray(values), np.asarray(expected), ulps(values, expected)
    rows = len(apart)
    one, other = (np.asarray(series[:rows], np.float64) for series in (values, expected))
    # a number on one side only counts as infinitely far from the other, whatever else can be compared
    size = np.where(np.isnan(one) != np.isnan(other), np.inf, np.abs(one - other))
    differing = np.flatnonzero(apart.reshape(rows, -1).any(axis=1)) if rows else np.empty(0, int)
    first = int(differing[0]) if differing.size else rows if len(a) != len(b) else None
    largest = float(np.nanmax(size, initial=0.0))
    ulp = int(apart.max(initial=0))
    return Difference(int(a[:rows].size), max(ulp, int(len(a) != len(b))), largest, first)


def ulps(values: NDArray[Any], expected: NDArray[Any]) -> NDArray[np.int64]:
    """Return the number of floats between elements of two series, over their common length."""
    rows = min(len(values), len(expected))
    one, other = (np.asarray(series[:rows], np.float32) for series in (values, expected))
    apart: NDArray[np.int64] = np.abs(_ordered(one) - _ordered(other))
    return apart


def _ordered(values: NDArray[np.float32]) -> NDArray[np.int64]:
    """Return the rank of each float among all floats, with equal ranks for all NaN and for both zeros."""
    bits = np.where(np.isnan(values), np.float32(np.nan), values).astype(np.float32).view(np.int32).astype(np.int64)
    return np.where(bits < 0, -(bits & 0x7FFFFFFF), bits)
