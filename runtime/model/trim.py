# SPDX-License-Identifier: Apache-2.0
"""Trim points of a plant: states and inputs at which the rates vanish."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mehvar.base.errors import MehvarError, bad_value, unknown_name
from mehvar.base.names import CLOCK

from ..arguments import check_arguments
from .functions import FloatArray, displacement
from .model import Model, load
from .parameters import number

_TOLERANCE = 1e-12
"""Tolerance of residual, step and gradient, relative to the scales of the unknowns. Half or twice this value changes
the number of Newton steps by at most one.
"""
_STEADY = 1e-8
"""Tolerance of a rate, relative to its change when each unknown changes by its size or one. Rounding leaves 1e-16,
and at a double zero half of the digits. A tenth or ten times changes no verdict.
"""
_ROUNDING = 1e-12
"""Bound on the rounding errors of rates that no unknown changes."""
_PROBE = 6e-6
"""Relative step of central differences of the projection, the cube root of double rounding. They only guide the
search; ten times more or less costs one step.
"""


@dataclass(frozen=True, eq=False)
class Trim:
    """A trim point; unpacks as (x, u, residual).

    Attributes
    ----------
    x, u : array
        State and input.
    residual : array
        Rates of the states in `steady`, in order.
    steady : tuple of str
        States whose rates should vanish.
    values : mapping of str to float
        Solved unknowns.
    at_bounds : tuple of str
        Unknowns at a bound.
    evaluations : int
        Number of evaluations of the right-hand side.
    """

    x: FloatArray
    u: FloatArray
    residual: FloatArray
    steady: tuple[str, ...]
    values: Mapping[str, float]
    at_bounds: tuple[str, ...]
    evaluations: int

    def __iter__(self) -> Iterator[FloatArray]:
        return iter((self.x, self.u, self.residual))


class TrimError(MehvarError, ValueError):
    """Error if no steady state was found; `point` is the `Trim` with the smallest rates."""

    def __init__(self, message: str, point: Trim) -> None:
        super().__init__(message)
        self.point = point


def trim(
    model: Model | str | os.PathLike[str],
    fix: Mapping[str, float] | None = None,
    free: Sequence[str] | Mapping[str, float] = (),
    p: ArrayLike | None = None,
    *,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    steady: Sequence[str] | None = None,
) -> Trim:
    """Find states and inputs at which the plant's rates vanish, by least squares with exact Jacobians.

    Parameters
    ----------
    model : Model, str or path
        A loaded model, or what `load` takes.
    fix : mapping, optional
        Values of states and inputs by name; all that are neither fixed nor free are zero.
    free : sequence of str or mapping
        Unknown states and inputs. A mapping gives start values; default: zero or within the bounds.
    p : array_like, optional
        Parameters of the plant; default: those of the model.
    bounds : mapping, optional
        Lowest and highest value of unknowns.
    steady : sequence of str, optional
        States whose rates vanish; default: all except the clock of a time-varying plant.

    Returns
    -------
    Trim
        Unpacks as (x, u, residual), with a residual of rounding errors.

    Raises
    ------
    InputError
        If a name is unknown or both fixed and free, there are no unknowns, bounds are invalid, or the start is no
        valid state, such as a quaternion of zeros.
    TrimError
        If the rates do not vanish at the end of the search, or the end is no valid state; `point` has this end.

    Examples
    --------
    >>> import mehvar
    >>> point = mehvar.trim("satellite", fix={"hy": 0.1}, free=["roll", "pitch", "yaw", "wx", "wy", "wz"],
    ...                     steady=["wx", "wy", "wz", "roll", "pitch", "yaw"])
    >>> bool(abs(point.residual).max() < 1e-12)
    True
    """
    check_arguments("mapping", "the call", fix=fix, bounds=bounds)
    loaded = model if isinstance(model, Model) else load(model)
    names = (*loaded.state_names, *loaded.input_names)
    starts = dict(free) if isinstance(free, Mapping) else dict.fromkeys(_texts("free", free), None)
    steady = tuple(name for name in loaded.state_names if name != CLOCK) if steady is None else _texts("steady", steady)
    limits = dict(bounds or {})
    for kind, named in (("fix", fix or {}), ("free", starts), ("bounds", limits)):
        for name in named:
            if name not in names:
                raise unknown_name(f"state or input of {loaded.name} in {kind}", name, names)
    for name in steady:
        if name not in loaded.state_names:
            raise unknown_name(f"state of {loaded.name} in steady", name, loaded.state_names)
    for name in (*(fix or {}), *limits):
        if (name in starts) == (name in (fix or {})):
            raise bad_value(name, "fixed and free" if name in starts else "not free", "fixed, or free with bounds")
    if not starts:
        raise bad_value("free", list(starts), f"one or more of {', '.join(names)}")
    given = np.array([number(name, (fix or {}).get(name, 0.0), "fix") for name in names])
    lower, upper = (np.array([_bound(name, limits, side) for name in starts]) for side in (0, 1))
    if not np.all(lower < upper):
        raise bad_value("bounds", limits, "pairs of a lower and a higher number")
    begin = np.array([0.0 if value is None else number(name, value, "free") for name, value in starts.items()])
    places = [names.index(name) for name in starts]
    rows = [loaded.state_names.index(name) for name in steady]
    nx = len(loaded.state_names)
    parameters = loaded.parameters() if p is None else loaded.functions["rhs"].argument("p", p)

    def at(unknown: FloatArray) -> tuple[FloatArray, FloatArray]:
        given[places] = unknown
        return given[:nx].copy(), given[nx:].copy()

    def rates(unknown: FloatArray) -> FloatArray:
        return loaded.rhs(*at(unknown), parameters)[rows]

    def slopes(unknown: FloatArray) -> FloatArray:
        x, u = at(unknown)
        both = np.hstack([loaded.jac_x(x, u, parameters), loaded.jac_u(x, u, parameters)])
        return np.asarray(both[np.ix_(rows, places)])

    from scipy.optimize import least_squares

    inside = np.clip(begin, lower, upper)
    if not np.isfinite(rates(inside)).all():
        start = dict(zip(starts, inside.tolist(), strict=True))
        raise bad_value("free", start, "a start at which the rates are finite")
    gap = _gap(loaded, parameters)
    if nowhere := [n for n, g in zip(loaded.state_names, gap(at(inside)[0]), strict=False) if not np.isfinite(g)]:
        allowed = f"fixed, or free with a start, at which they are a state of {loaded.name}"
        raise bad_value(", ".join(nowhere), 0.0, allowed)

    def residual(unknown: FloatArray) -> FloatArray:
        return np.concatenate([rates(unknown), gap(at(unknown)[0])])

    def gradients(unknown: FloatArray) -> FloatArray:
        probes = _PROBE * np.eye(len(unknown))
        columns = [gap(at(unknown + d)[0]) - gap(at(unknown - d)[0]) for d in probes]
        return np.vstack([slopes(unknown), np.column_stack(columns) / (2 * _PROBE)])

    tolerances = dict.fromkeys(("xtol", "ftol", "gtol"), _TOLERANCE)
    result = least_squares(residual, inside, gradients, bounds=(lower, upper), x_scale="jac", **tolerances)
    x, u = at(result.x)
    point = Trim(
        x=x,
        u=u,
        residual=rates(result.x),
        steady=tuple(loaded.state_names[row] for row in rows),
        values=dict(zip(starts, result.x.tolist(), strict=True)),
        at_bounds=tuple(name for name, active in zip(starts, result.active_mask, strict=True) if active),
        evaluations=int(result.nfev),
    )
    _check_steady(point, slopes(result.x), result.x)
    if np.abs(gap(x)).max(initial=0.0) > _STEADY:
        raise TrimError(
            f"{loaded.name} has no steady state near the start: at the best point {_off(loaded, gap(x))}", point
        )
    return point


def _gap(model: Model, p: FloatArray) -> Callable[[FloatArray], FloatArray]:
    """Return a state's projection minus the state, empty without a projection."""
    return lambda x: displacement(model.manifest, model.functions, x, p)


def _off(model: Model, gap: FloatArray) -> str:
    worst = int(np.argmax(np.abs(gap)))
    return f"{model.state_names[worst]} is off its manifold by {gap[worst]:.3g}"


def _check_steady(point: Trim, slopes: FloatArray, unknowns: FloatArray) -> None:
    """Refuse a point at which a required rate exceeds rounding; the message names the worst."""
    allowed = _STEADY * np.abs(slopes) @ np.maximum(np.abs(unknowns), 1.0) + _ROUNDING
    excess = np.abs(point.residual) / allowed
    if np.all(excess <= 1):
        return
    worst = int(np.argmax(np.where(np.isnan(excess), np.inf, excess)))
    bounds = f"; at a bound: {', '.join(point.at_bounds)}" if point.at_bounds else ""
    rate = f"the rate of {point.steady[worst]} is {point.residual[worst]:.3g}"
    hint = "Free more states or inputs, begin elsewhere, or name in steady the states whose rates must vanish"
    raise TrimError(f"no steady state found: {rate} where the search ended{bounds}. {hint}", point)


def _texts(name: str, value: object) -> tuple[str, ...]:
    texts = tuple(value) if isinstance(value, Iterable) and not isinstance(value, str) else (None,)
    if not all(isinstance(text, str) for text in texts):
        raise bad_value(name, value, "a list of names", "the call")
    return texts


def _bound(name: str, bounds: Mapping[str, tuple[float, float]], side: int) -> float:
    pair = bounds.get(name, (-np.inf, np.inf))
    try:
        value = float(pair[side])
    except (TypeError, ValueError, LookupError, OverflowError) as error:
        raise bad_value(f"bounds of {name}", pair, "a lower and a higher number") from error
    if np.isnan(value):
        raise bad_value(f"bounds of {name}", pair, "a lower and a higher number")
    return value
