# SPDX-License-Identifier: Apache-2.0
"""Gain and phase margins of a loop that is cut at each input in turn: of the linear loop, or of the running one."""

from __future__ import annotations

import cmath
import itertools
import math
import os
import warnings
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from mehvar.base.errors import InputError, bad_value, unknown_name
from mehvar.base.names import identifier
from mehvar.runtime.arguments import check_arguments
from mehvar.runtime.model.functions import FloatArray
from mehvar.runtime.model.linear import COUNTER, ClosedLoop, LinearSystem, modes
from mehvar.runtime.model.model import Model, load
from mehvar.runtime.model.parameters import number_above
from mehvar.runtime.run.problem import Status
from mehvar.runtime.run.simulate import Run, simulate

from .turns import in_turns

_LIMIT = 0.01
"""Largest relative change of a response that has a limit, from 1/1000 to 1/10 000 of the slowest natural frequency: by
a first-order lag it is 0.001, by an integrator that acts on the output 10. Other integrators cancel."""
_BEYOND = (0.01, 0.1)
"""Steps of the logarithm beyond a factor at which instability is looked for: with the second, slow growth is above its
error."""
_POINTS = 1000
"""Number of frequencies in the grid that finds crossings, besides those of the eigenvalues, where responses are
steepest. Half or twice this number changes no margin of the three shipped models.
"""
_DECADES = 2
"""Decades of the grid below the slowest and above the fastest eigenvalue. At both ends a first-order lag is within 1 %
of its asymptote."""


_ROUNDING = 1e-6
"""Tolerance of a phase, rad, and of a logarithmic gain. Below the slowest pole, rounding of about 1e-9 moves a real
response across the axis at random; true crossings have clear values on both sides."""
_MEASURED = 1e-3
"""The same tolerance of a measured response; also its relative error, of 0.01 dB. Ten times the tolerance leaves errors
of 0.1 dB, a tenth doubles the length of runs with slow transients."""
_STILL, _ACTING, _TURNING = 0.1, 1e-3, 0.1
"""Largest relative change of a mode, in its time, of a loop that is still; margins are judged by factors of two. Least
angle of a mode in a run, and of one without damping: slower ones are integrators, coupled by noise or by what the
motion left, such as angles about two axes at a small rate about the third."""
_FASTEST = 2
"""Rate of the fastest mode of an orbit and of the attitude in its gravity gradient, by the rate of the orbit: of roll.
Where the craft goes round, the linear loop of a moment has errors of this size. Source: Hughes, Spacecraft Attitude
Dynamics, Wiley 1986, chapter 9."""
_LARGEST = 1e3
"""Largest gain factor: rounding and the tolerance of the integration hide larger and smaller responses."""
_PER_DECADE, _SWEPT = 10, 3
"""Frequencies of a sweep per decade, and its decades below the Nyquist frequency."""
_PERIODS = 4
"""Periods of the first run at a frequency. Its middle and its second half must agree, else a run is doubled."""
_FEWEST, _MOST = 64, 200_000
"""Least and most samples of a run at one frequency; the most take about two seconds."""


@dataclass(frozen=True)
class Margin:
    """Stability margins at one input, with all other loops closed.

    Attributes
    ----------
    input : str
        The input at which the loop is opened.
    gain : float
        Gain factor nearest to one that makes the loop unstable; infinite if there is none.
    phase : float
        Loss of phase that makes the loop unstable, rad; infinite if there is none.
    """

    input: str
    gain: float
    phase: float

    @property
    def text(self) -> str:
        """Both margins in words, the phase in degrees; NaN stands for a loop that is unstable as it is."""
        if math.isnan(self.gain):
            return "the loop is unstable"
        return f"gain margin {self.gain:.3g} (factor), phase margin {math.degrees(self.phase):.3g} deg"

    @property
    def is_endless(self) -> bool:
        """True if no gain factor and no loss of phase makes the loop unstable."""
        return math.isinf(self.gain) and math.isinf(self.phase)

    def __str__(self) -> str:
        return f"{self.input}: {self.text}"


def margins(
    model: Model | str | os.PathLike[str],
    controller: str,
    scenario: str | None = None,
    *,
    size: float | Mapping[str, float] | None = None,
    frequencies: Sequence[float] | None = None,
    **run: Any,
) -> tuple[Margin, ...]:
    """Return gain and phase margins at each input of a closed loop, at the state where a scenario ends.

    Without `size` they are the margins of the linear loop, without a craft's orbit if the loop does not move it. With
    `size` they are measured: a sine is added to the command in the running loop of generated C, with its sensors,
    delays, limits and sampling. Half of the difference of two runs with opposite sines gives the response; noise is
    equal in both runs.

    Parameters
    ----------
    model, controller, scenario
        As of `mehvar.simulate`; the law is one of the model.
    size : float or mapping of str to float, optional
        Amplitude of the sine, in the unit of the input; or amplitudes of the inputs at which to measure. Choose it
        small where a limit or a dead zone must not act.
    frequencies : sequence of float, optional
        Frequencies of the sweep in rad/s, increasing, at most the Nyquist frequency. Default: 10 per decade over three
        decades below the Nyquist frequency, with the natural frequencies of the linear loop. Crossings are refined;
        crossings beyond the sweep, or two between neighbouring frequencies, are not noticed.
    **run
        Further arguments of `mehvar.simulate`, such as `parameters`, `initial`, `t_end`, `delay`, and a `dt_out` that
        fits the period of the law where the step of the scenario does not.

    Returns
    -------
    tuple of Margin
        For each input that the law uses. Factors above 1000 and below 1/1000 are infinite. Warnings say that the
        linear loop still changes where the scenario ends, that a tank drains there, or that the margins leave out modes
        as slow as the craft's orbit.

    Raises
    ------
    InputError
        If the loop is unstable, does not settle or has no linear system, or an argument is unknown or out of bounds.

    Examples
    --------
    >>> import mehvar
    >>> [f"{m.input}: {m.phase:.3f} rad" for m in mehvar.margins("satellite", "pd", t_end=200.0)]
    ['Tx: 0.219 rad', 'Ty: 0.036 rad', 'Tz: 0.036 rad']
    """
    check_arguments("text", "the call", controller=controller, scenario=scenario)
    loaded = model if isinstance(model, Model) else load(model, "c")
    if not isinstance(controller, str):
        raise bad_value("controller", controller, "the name of a law of the model")
    for name in {"law", "hold", "real", "inputs", "interpolation", "period", "memory"} & run.keys():
        raise bad_value(name, run[name], "left out: margins are of a law of the model, at its own period and in double")
    base = simulate(loaded, controller, scenario, **run)
    if base.status is not Status.DONE:
        raise InputError(f"{base.controller.name} has no margins where {base.scenario.name} ends: {base.reason}")
    if tanks := draining(loaded, base):
        text = f"the margins are those of a moment: where {base.scenario.name} ends, fuel leaves {', '.join(tanks)}"
        warnings.warn(text, stacklevel=2)
    if size is None:
        if frequencies is not None:
            raise bad_value("frequencies", frequencies, "left out without size: only measured margins need them")
        if base.options.get("delay"):
            raise bad_value("delay", base.options["delay"], "0 for the linear loop; give size to measure the margins")
        try:
            loop = linear_loop(loaded, base)
        except InputError as error:
            raise InputError(f"{error}; give size to measure the margins") from error
        if not np.all(np.isfinite(loop.A + loop.B @ loop.C)):
            where = f"where {base.scenario.name} ends"
            raise InputError(f"{base.controller.name} has no derivative {where}; give size to measure the margins")
        slow = orbit_modes(loaded, base.x[-1])
        result = linear_margins(loop, slow)
        changing = moving(loaded, base)
        if not result:
            moment = ", a moment of a motion: give a longer t_end" if changing else ""
            where = f"where {base.scenario.name} ends{moment}"
            raise InputError(f"the linear loop of {base.controller.name} is unstable {where}")
        if changing:
            text = (
                f"the loop of {base.controller.name} still moves where {base.scenario.name} ends, so that the margins "
            )
            warnings.warn(text + "are those of a moment: give a longer t_end, or size to measure them", stacklevel=2)
        if undecided := left_out(loop, slow, result):
            if any(margin.is_endless for margin in result):
                raise InputError(f"{undecided}; give size to measure the margins")
            warnings.warn(undecided, stacklevel=2)
        return result
    if COUNTER in (memory := [q.name for q in base.controller.memory]) and base.z[:, memory.index(COUNTER)].any():
        raise InputError(f"{base.controller.name} commands only at some samples: margins need a command at each sample")
    if base.hold is None:
        raise InputError(f"{base.controller.name} is continuous, so that no sine can be added: leave size out")
    if not base.options.get("delay") and unstable(loaded, base):
        raise InputError(f"the linear loop of {base.controller.name} is unstable where {base.scenario.name} ends")
    loops = [_Sweep(loaded, base, run, *pair, frequencies) for pair in _sizes(loaded, size)]
    return tuple(Margin(loop.input, loop.gain(), loop.phase()) for loop in loops if loop.acts)


def _sizes(model: Model, size: object) -> list[tuple[str, float]]:
    """Return the inputs at which to measure with their amplitudes."""
    if isinstance(size, Mapping) and not size:
        raise bad_value("size", size, "a number, or amplitudes of one input or more")
    sizes: Mapping[Any, object] = size if isinstance(size, Mapping) else dict.fromkeys(model.input_names, size)
    units = {q.name: q.unit for q in model.manifest.inputs}
    for name in sizes:
        if name not in units:
            raise unknown_name("input", name, units, "size")
    return [(name, number_above(0, f"size of {name}", v, f"a number > 0, {units[name]}")) for name, v in sizes.items()]


def linear_loop(model: Model, run: Run, sample: int = -1) -> LinearSystem:
    """Return the linear loop at a sample of a run, the last by default, cut between law and plant, beside its orbit."""
    p, s, c = run.parameters.p, run.parameters.s, run.parameters.c
    z = run.z[sample] if run.controller.memory else None
    held = run.u[sample] if run.controller.memory and run.controller.period else None
    r = model.functions["reference"](run.t[sample], p, s)
    cut = ClosedLoop(model.manifest, model.functions, run.controller, run.x[sample], held, p, r, c, z).cut()
    return beside_orbit(in_turns(model.manifest, cut, run.x[sample]), [name for own in _orbits(model) for name in own])


def _orbits(model: Model) -> list[list[str]]:
    """Return the names of the states of each orbit, place before velocity."""
    orbits = [name for name, part in model.manifest.parts.items() if part.get("") == "Orbit"]
    return [[f"{name}_{v}{axis}" for v in ("", "v") for axis in "xyz"] for name in orbits]


def beside_orbit(cut: LinearSystem, orbit: Sequence[str]) -> LinearSystem:
    """Return a loop without the states of an orbit that it does not move; else the loop.

    Where an orbit is frozen it has a mode that grows with sqrt(2) times its rate, which is no instability of the loop.
    It drives the loop from outside if all modes stay where they are once nothing acts on it: forces of the gravity
    gradient and of the air hardly do. An orbit that the law keeps stays in the loop, as do all modes of other kinds.

    Parameters
    ----------
    cut : LinearSystem
        As `mehvar.runtime.model.linear.ClosedLoop.cut` returns it.
    orbit : sequence of str
        Names of the orbit's states.
    """
    own = np.isin(cut.states, orbit)
    if not own.any() or not np.all(np.isfinite(cut.A + cut.B @ cut.C)):
        return cut
    rest, A, B = ~own, cut.A.copy(), cut.B.copy()
    A[np.ix_(own, rest)] = B[own] = 0
    rate = np.min(np.abs(_exponents(replace(cut, A=A[np.ix_(own, own)], B=B[own], C=cut.C[:, own]))[0]))
    changes = _changes(cut, replace(cut, A=A, B=B))
    if changes is None or np.any(changes[1] > _STILL * np.maximum(np.abs(changes[0]), rate)):
        return cut
    names = tuple(name for name, kept in zip(cut.states, rest, strict=True) if kept)
    return replace(cut, A=cut.A[np.ix_(rest, rest)], B=cut.B[rest], C=cut.C[:, rest], states=names)


def draining(model: Model, run: Run) -> list[str]:
    """Return the tanks that fuel leaves where a run ends; the loop changes with their mass."""
    states = [q.name for q in model.manifest.states]
    tanks = (name for name, part in model.manifest.parts.items() if part.get("") == "Tank")
    return [name for name in tanks if np.ptp(run.x[-2:, states.index(f"{name}_fuel")])]


def orbit_modes(model: Model, x: FloatArray) -> float:
    """Return the rate of modes, 1/s, that belong to the motion in an orbit at a state; zero without an orbit."""
    names = [q.name for q in model.manifest.states]
    states = ([names.index(name) for name in own] for own in _orbits(model))
    vectors = ((x[own[:3]], x[own[3:]]) for own in states)
    rates = (float(np.linalg.norm(np.cross(place, v)) / (place @ place)) for place, v in vectors)
    return _FASTEST * max(rates, default=0.0)


def left_out(cut: LinearSystem, slow: float, margins: Sequence[Margin]) -> str:
    """Return which margins leave out modes as slow as the orbit, and why; empty if that changes none."""
    every = linear_margins(cut)
    names = [margin.input for margin in margins if margin not in every]
    if not names:
        return ""
    growth = "" if every else f", of which one grows by {np.max(_exponents(cut)[0].real):.2g} 1/s"
    return (
        f"margins at {', '.join(names)} leave out modes slower than {slow:.3g} 1/s, twice the rate of the orbit"
        f"{growth}: the linear loop of a moment, in which the craft does not go round, does not decide about them"
    )


def moving(model: Model, run: Run) -> bool:
    """Return True if a mode of the linear loop still changes where a run ends: 10 % while it decays, or in another run.

    The margins are then those of a moment. They can mislead: a loop may be near instability, or beyond it, at each
    moment of a turn that converges.
    """
    changes = _changes(*(linear_loop(model, run, k) for k in (-2, -1)))
    if changes is None:
        return True
    last, change = changes[0], changes[1] / (run.t[-1] - run.t[-2])
    shortest = np.maximum(np.abs(last.real), 1 / run.t[-1])
    acting = np.abs(last) * run.t[-1] > np.where(np.abs(last.real) > _ROUNDING * np.abs(last), _ACTING, _TURNING)
    return bool(np.any(acting & (change > _STILL * np.abs(last) * shortest)))


def _changes(old: LinearSystem, new: LinearSystem) -> tuple[NDArray[np.complex128], FloatArray] | None:
    """Return the exponents of a closed loop's modes and their changes beyond errors; None if their number changes."""
    (before, noise), (last, error) = map(_exponents, (old, new))
    if len(before) != len(last):
        return None
    order = linear_sum_assignment(np.abs(before[:, None] - last))[1]
    last, noise = last[order], noise + error[order]
    return last, np.maximum(np.abs(last - before) - noise, 0)


def _exponents(cut: LinearSystem) -> tuple[NDArray[np.complex128], FloatArray]:
    """Return the exponents of a closed loop's modes, 1/s, and their errors, without modes that last one sample."""
    values, errors = modes(cut.A + cut.B @ cut.C)
    exponents = values.astype(np.complex128)
    if cut.period is None:
        return exponents, errors
    lasting = np.abs(exponents) > np.maximum(errors, np.finfo(float).eps)
    exponents, errors, period = exponents[lasting], errors[lasting], float(cut.period)
    exponents = (np.log(exponents) / period).astype(np.complex128)
    return exponents, errors / np.abs(values[lasting]) / period


def linear_margins(cut: LinearSystem, slow: float = 0.0) -> tuple[Margin, ...]:
    """Return the margins at each input that a law uses, or nothing if the closed loop is unstable.

    Parameters
    ----------
    cut : LinearSystem
        As `mehvar.runtime.model.linear.ClosedLoop.cut` returns it.
    slow : float
        Rate, 1/s, up to which modes may grow, such as `orbit_modes` returns it.
    """
    closed = cut.A + cut.B @ cut.C
    if not np.all(np.isfinite(closed)) or is_unstable(closed, cut.period, slow):
        return ()
    loops = ((name, _Loop(cut, closed, number, slow)) for number, name in enumerate(cut.inputs))
    return tuple(Margin(name, loop.gain(), loop.phase()) for name, loop in loops if loop.acts)


def unstable(model: Model, run: Run) -> bool:
    """Return True if the linear loop at the end of a run is unstable; False also where there is none.

    A sine drives an unstable loop to another rest, such as the other sign of a quaternion, and would be measured there.
    """
    try:
        cut = linear_loop(model, run)
    except InputError:  # of delays, skipped samples, or a model without derivatives
        return False
    closed = cut.A + cut.B @ cut.C
    return bool(np.all(np.isfinite(closed))) and is_unstable(closed, cut.period, orbit_modes(model, run.x[-1]))


def is_unstable(matrix: NDArray[Any], period: FloatArray | float | None, slow: float = 0.0) -> bool:
    """Return True if a mode grows that is not slow; eigenvalues of integrators are on the limit up to their errors."""
    eigenvalues, errors = modes(matrix)
    growth = eigenvalues.real if period is None else np.abs(eigenvalues) - 1
    growing = eigenvalues[growth > errors]
    return bool(np.any(np.abs(growing if period is None else np.log(growing) / period) > slow))


class _Response(ABC):
    """Frequency response of the open loop at one input, with opposite sign.

    The closed loop is unstable if the response encircles -1.
    """

    _frequencies: FloatArray
    _values: NDArray[np.complex128]
    rounding: float
    """Size of phases and logarithmic gains that count as zero."""
    accuracy: float
    """Relative accuracy of crossing frequencies."""

    @abstractmethod
    def at(self, frequency: float) -> complex:
        """Return the response at an angular frequency, rad/s."""

    @abstractmethod
    def _ends(self) -> Iterator[complex]:
        """Yield the response at frequencies where it is real: zero and, for a sampled loop, the Nyquist frequency."""

    def loses(self, factor: complex) -> bool:  # noqa: ARG002
        """Return False if stability is known to last beyond a factor."""
        return True

    def gain(self) -> float:
        """Return the gain factor nearest to one at which the response passes through -1."""
        crossings = [self.at(w) for w in self._crossings(lambda value: value.imag / abs(value) if value else math.inf)]
        factors = [-1 / value.real for value in (*crossings, *self._ends()) if -math.inf < value.real < 0]
        known = (factor for factor in factors if abs(math.log(factor)) <= math.log(_LARGEST))
        return next(filter(self.loses, sorted(known, key=lambda factor: abs(math.log(factor)))), math.inf)

    def phase(self) -> float:
        """Return the smallest angle between the response and -1 at gain one."""
        crossings = [self.at(w) for w in self._crossings(lambda value: math.log(abs(value)) if value else -math.inf)]
        angles = sorted((float(np.angle(-1 / value)) for value in crossings), key=abs)
        return next((abs(angle) for angle in angles if self.loses(cmath.exp(1j * angle))), math.inf)

    def _crossings(self, what: Callable[[complex], float]) -> Iterator[float]:
        """Yield the frequencies at which a quantity of the response changes sign; ignore rounding."""
        from scipy.optimize import brentq  # takes half a second, which an unchanged model does not need

        signs = [(w, what(value)) for w, value in zip(self._frequencies, self._values, strict=True)]
        significant = [(w, sign) for w, sign in signs if math.isfinite(sign) and abs(sign) > self.rounding]
        for (low, a), (high, b) in itertools.pairwise(significant):
            if a * b < 0:
                yield float(brentq(lambda w: what(self.at(w)), low, high, xtol=self.accuracy * high))


class _Loop(_Response):
    """Response of a linear loop."""

    rounding, accuracy = _ROUNDING, 1e-12

    def __init__(self, cut: LinearSystem, closed: FloatArray, number: int, slow: float) -> None:
        self._slow = slow
        self._b, self._c = cut.B[:, number], cut.C[number]
        self._A = closed - np.outer(self._b, self._c)
        self._period = None if cut.period is None else float(cut.period)
        self._eye = np.eye(len(closed))
        self.acts = bool(np.any(self._c) and np.any(self._b))
        self._frequencies = self._grid(closed) if self.acts else np.empty(0)
        self._values = np.array([self.at(w) for w in self._frequencies])

    def at(self, frequency: float) -> complex:
        s = 1j * frequency if self._period is None else np.exp(1j * frequency * self._period)
        try:
            return complex(-self._c @ np.linalg.solve(s * self._eye - self._A, self._b))
        except np.linalg.LinAlgError:  # on a pole
            return complex(math.inf)

    def _ends(self) -> Iterator[complex]:
        near, nearer = self._frequencies[0] / 10, self._frequencies[0] / 100
        ends = [(near, nearer)]
        if self._period is not None:
            ends.append((math.pi / self._period - near, math.pi / self._period - nearer))
        for pair in ends:
            before, value = map(self.at, pair)
            if abs(value - before) <= _LIMIT * abs(value):
                yield complex(value.real)

    def loses(self, factor: complex) -> bool:
        """Return True if the closed loop is unstable beyond a factor; rounding of integrators feigns other limits."""
        feedback, log = np.outer(self._b, self._c), cmath.log(factor)
        way = log / abs(log) if log else 1.0
        beyond = (cmath.exp(log + step * way) for step in _BEYOND)
        return any(is_unstable(self._A + each * feedback, self._period, self._slow) for each in beyond)

    def _grid(self, closed: FloatArray) -> FloatArray:
        sizes = np.concatenate([_natural(matrix, self._period) for matrix in (self._A, closed)])
        low, high = (np.min(sizes), np.max(sizes)) if sizes.size else (1.0, 1.0)
        highest = 10**_DECADES * high if self._period is None else math.pi / self._period
        grid = np.geomspace(min(low / 10**_DECADES, highest / 2), highest, _POINTS)
        return np.unique(np.concatenate([grid, sizes[sizes < highest]]))


def _natural(matrix: FloatArray, period: float | None) -> FloatArray:
    """Return the natural frequencies of modes, without those of integrators."""
    eigenvalues, errors = modes(matrix)
    kept = eigenvalues[np.abs(eigenvalues - (0 if period is None else 1)) > errors]
    sizes: FloatArray = np.abs(kept if period is None else np.log(kept[kept != 0]) / period)
    return sizes


@dataclass
class _Sweep(_Response):
    """Response of a running sampled loop, measured by sines that are added to a command."""

    model: Model
    base: Run
    options: Mapping[str, Any]
    input: str
    size: float
    frequencies: Sequence[float] | None
    rounding: float = _MEASURED
    accuracy: float = _MEASURED
    _known: dict[float, complex] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._period = float(self.base.hold or 0)
        self._highest = math.pi / self._period
        self._number = self.model.input_names.index(self.input)
        self._begin = math.ceil(float(self.base.t[-1]) / self._period)
        self._frequencies = self._grid() if self.frequencies is None else self._given(self.frequencies)
        self._values = np.array([self.at(w) for w in self._frequencies])

    @property
    def acts(self) -> bool:
        """True if the law commands the input: a filter that trusts its model commands it without a response."""
        return bool(np.any(np.abs(self._values) > 1 / _LARGEST) or np.any(self.base.u_cmd[:, self._number]))

    def at(self, frequency: float) -> complex:
        if frequency not in self._known:
            self._known[frequency] = self._measured(frequency)
        return self._known[frequency]

    def _ends(self) -> Iterator[complex]:
        for w in (0.0, self._highest):
            if (value := self.at(w)) and abs(value) < _LARGEST:
                yield complex(value.real)

    def _grid(self) -> FloatArray:
        """Return frequencies at equal ratios, with those of the linear loop where there is one."""
        grid = self._highest * np.geomspace(10.0**-_SWEPT, 1, _SWEPT * _PER_DECADE + 1)
        try:
            cut = linear_loop(self.model, self.base)
        except InputError:  # of a loop with delays, or of a model without derivatives
            return grid
        opened = cut.A + cut.B @ cut.C - np.outer(cut.B[:, self._number], cut.C[self._number])
        if not np.all(np.isfinite(opened)):
            return grid
        natural = _natural(opened, self._period)
        return np.unique(np.concatenate([grid, natural[(natural > grid[0]) & (natural < self._highest)]]))

    def _given(self, frequencies: Sequence[float]) -> FloatArray:
        """Return the given frequencies, rad/s; refuse any that do not increase from above 0 to at most pi/Ts."""
        try:
            grid = np.asarray(frequencies, dtype=np.float64)
        except (TypeError, ValueError):
            grid = np.empty(0)
        within = grid.ndim == 1 and grid.size > 1 and np.all(np.diff(grid) > 0)
        if not (within and grid[0] > 0 and grid[-1] <= self._highest * (1 + _ROUNDING)):
            text = f"two numbers or more, increasing, above 0 and at most pi/Ts = {self._highest:.6g} rad/s"
            raise bad_value("frequencies", frequencies, text)
        return np.minimum(grid, self._highest)

    def _measured(self, frequency: float) -> complex:
        """Return the response once two successive parts of a run agree."""
        once = 2 * math.pi / (frequency * self._period) if frequency else 0.0
        count = max(_FEWEST, math.ceil(_PERIODS * once))
        while count <= _MOST:
            change = self._changed(frequency, count)
            part = count // 2
            before, after = (1 / self._share(frequency, change, end, part) - 1 for end in (count - part // 2, count))
            if abs(after - before) <= _MEASURED * max(abs(after), 10 / _LARGEST) or abs(after) > _LARGEST:
                return after
            count *= 2
        raise InputError(
            f"the loop of {self.base.controller.name} does not settle within {_MOST} samples of a sine at "
            f"{frequency:.6g} rad/s on {self.input}: it is unstable, or slower than this"
        )

    def _share(self, frequency: float, change: FloatArray, end: int, count: int) -> complex:
        """Return the sine in a part of a command per added sine, beside a constant and a slope, by least squares.

        Hann's weights keep transients of other frequencies out.
        """
        k = np.arange(end - count, end)
        angle, middle = frequency * self._period * k, (k - k.mean()) / count
        if frequency == 0:
            columns = [np.ones(count), middle]
        elif frequency == self._highest:
            columns = [np.cos(math.pi * k), np.ones(count), middle]
        else:
            columns = [np.cos(angle), np.sin(angle), np.ones(count), middle]
        weights = np.hanning(count + 2)[1:-1]
        weighted = weights[:, None] * np.stack(columns, axis=1)
        fit = np.linalg.lstsq(weighted, weights * change[end - count : end], rcond=None)[0]
        alone = frequency in (0, self._highest)
        return complex(fit[0], 0.0 if alone else -fit[1]) or complex(1 / _LARGEST**2)

    def _changed(self, frequency: float, count: int) -> FloatArray:
        """Return half of the difference of the commands under opposite cosines, per amplitude."""
        first, second = (self._run(frequency, sign * self.size, count) for sign in (1, -1))
        change: FloatArray = (first - second) / (2 * self.size)
        return change

    def _run(self, frequency: float, size: float, count: int) -> FloatArray:
        """Return the command of a run to which a cosine is added after the scenario."""
        base, number, begin = self.base, self._number, self._begin
        law, p, c = self.model.functions[identifier(base.controller.name)], base.parameters.p, base.parameters.c
        added = size * np.cos(frequency * self._period * np.arange(count + 1))
        samples = itertools.count(-begin)

        def call(x: FloatArray, r: FloatArray, v: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
            u, z_next = law(x, r, v, z, p, c) if len(z) else (law(x, r, p, c), z)
            if (k := next(samples)) >= 0:
                u = np.array(u)
                u[number] += added[k]
            return u, z_next

        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # advice, which the first run gives
            options = {**self.options, "t_end": (begin + count) * self._period, "dt_out": self._period}
            run = simulate(self.model, base.controller.name, base.scenario.name, law=call, **options)
        if run.status is not Status.DONE:
            raise InputError(
                f"size of {self.input} = {self.size:g}: the loop is unstable, or size too large: "
                f"with a sine at {frequency:.6g} rad/s, {run.reason}"
            )
        return run.u_cmd[begin : begin + count, number]
