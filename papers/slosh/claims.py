# SPDX-License-Identifier: Apache-2.0
"""Claims of the slosh paper, each checked by running the model."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from mehvar.reproduction import TIMES, Check, Checks, Expected, Runs, about, below, not_essential

from .positivity import positive
from .rows import FULL, LAWS, REDUCED, axial

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from mehvar.runtime import Run

    FloatArray = NDArray[np.float64]

_MORE = 1.5
"""Ratio of paths above which the swing counts as larger; measured ratios are 2.0 to 2.3."""
_ROUNDED = 0.03
"""Relative, of an angle given with two digits: 17 deg is 16.5 to 17.5."""
_STEP = 1e-5
"""Step of a central difference of V along the flow, s; only its sign matters."""
_DECAY = (475.0, 600.0)
"""Interval for time constants, s: the attitude is at rest, and the velocities are far above rounding error."""
_TURNING = 30.0
"""Interval for counting extrema, s: the swings under V2 are over by then; half of it still distinguishes the laws."""
_LATE = 100.0
"""s: from then on the bobs hang in the direction of the apparent gravity."""
LENGTHS: Mapping[str, float] = {"h1": 0.16, "h2": 0.19, "b": -0.16, "l1": 0.12}
"""As printed; the model reads 0.16 as 0/6 = 0.6, and so on."""
_LOOPS = tuple((law, settings) for settings in (REDUCED, FULL) for law in LAWS)
_ORDER = "reduced V1, V2, full V1, V2"
_PLANTS = (("reduced", REDUCED), ("full", FULL))


def _four(runs: Runs, what: str, bound: float, unit: str, size: Callable[[Run], float]) -> Check:
    """Return the check that a number of all four loops is below a bound."""
    return below(f"{what} ({_ORDER})", bound, [size(runs(law, "paper", **settings)) for law, settings in _LOOPS], unit)


def _at(run: Run, name: str, time: float) -> float:
    return float(run.variables()[name][np.argmin(np.abs(run.t - time))])


def _degrees_at(run: Run, time: float, *names: str) -> float:
    """Return the largest size of some angles at an instant."""
    return max(abs(float(np.degrees(_at(run, name, time)))) for name in names)


def _from_end(run: Run, time: float, name: str) -> float:
    return abs(float(np.degrees(_at(run, name, time) - run.variables()[name][-1])))


def _velocities(runs: Runs, expected: Expected) -> Sequence[Check]:
    end, constant = expected("time"), expected("constant")

    def off(run: Run) -> float:
        first, last = _DECAY
        constants = [(last - first) / np.log(_at(run, name, first) / _at(run, name, last)) for name in ("vy", "vz")]
        return float(np.abs(np.divide(constants, constant) - 1).max())

    return (
        _four(runs, f"|v_y| at {end:g} s", expected("vy"), "m/s", lambda run: abs(_at(run, "vy", end))),
        _four(runs, f"|v_z| at {end:g} s", expected("vz"), "m/s", lambda run: abs(_at(run, "vz", end))),
        _four(runs, f"distance of the time constants from {constant:g} s, relative", expected("near"), "", off),
    )  # fmt: skip


def _attitude(runs: Runs, expected: Expected) -> Sequence[Check]:
    return (_angles(runs, expected, "att1", "att2", "att3"),)


def _pendulum_angles(runs: Runs, expected: Expected) -> Sequence[Check]:
    return (_angles(runs, expected, "phi1", "phi2"),)


def _angles(runs: Runs, expected: Expected, *names: str) -> Check:
    """Return the check that some angles are near zero by a time."""
    time, bound = expected("time"), expected("angle")
    return _four(runs, f"largest angle at {time:g} s", bound, "deg", lambda run: _degrees_at(run, time, *names))


def _azimuths(runs: Runs, expected: Expected) -> Sequence[Check]:
    return _steady(runs, expected, 1), _steady(runs, expected, 2)


def _steady(runs: Runs, expected: Expected, k: int) -> Check:
    """Return the check that an azimuth is at its end by a time."""
    name, time, bound = f"theta{k}", expected(f"time{k}"), expected(f"theta{k}")
    return _four(runs, f"theta_{k} at {time:g} s from its end", bound, "deg", lambda run: _from_end(run, time, name))


def _pair(runs: Runs, settings: Mapping[str, Any]) -> tuple[Run, Run]:
    first, second = (runs(law, "paper", **settings) for law in LAWS)
    return first, second


def _difference(runs: Runs, settings: Mapping[str, Any], *names: str) -> FloatArray:
    """Return the larger difference of some series between the laws, over time."""
    first, second = (run.variables() for run in _pair(runs, settings))
    off: FloatArray = np.max([np.abs(first[name] - second[name]) for name in names], axis=0)
    return off


def _same_motion_of_the_hull(runs: Runs, expected: Expected) -> Sequence[Check]:
    checks = []
    for plant, settings in _PLANTS:
        vy, vz = (float(_difference(runs, settings, name).max()) for name in ("vy", "vz"))
        attitude = float(np.degrees(_difference(runs, settings, "att1", "att2", "att3")).max())
        checks += [
            below(f"largest difference of v_y, {plant}", expected("velocity"), vy, "m/s"),
            below(f"largest difference of v_z, {plant}", expected("velocity"), vz, "m/s"),
            below(f"largest difference of the attitude, {plant}", expected("attitude"), attitude, "deg"),
        ]
    return checks


def _extrema(values: FloatArray) -> int:
    return int(np.count_nonzero(np.diff(np.sign(np.diff(values)))))


def _more_swing(runs: Runs, expected: Expected) -> Sequence[Check]:
    checks, wanted = [], [expected("turns_v1"), expected("turns_v2")]
    most, most_at = expected("most"), expected("most_at")
    for plant, settings in _PLANTS:
        ratios = _ratios(runs, settings, "travel_phi1", "travel_phi2")
        pair = _pair(runs, settings)
        turns = [_extrema(run.variables()["phi1"][run.t <= _TURNING]) for run in pair]
        off, t = np.degrees(_difference(runs, settings, "phi1", "phi2")), pair[0].t
        late = below(
            f"largest difference of a phi after {_LATE:g} s, {plant}",
            expected("late"),
            float(off[t > _LATE].max()),
            "deg",
        )
        checks += [
            Check(
                f"path of phi_1, phi_2 in 20 s, V2 over V1, {plant}",
                f"> {_MORE:g}",
                " / ".join(f"{ratio:.2f}" for ratio in ratios),
                min(ratios) > _MORE,
            ),
            Check(
                f"extrema of phi_1 in {_TURNING:g} s, V1, V2, {plant}",
                "{:g} / {:g}".format(*wanted),
                "{:g} / {:g}".format(*turns),
                turns == wanted,
            ),
            Check(
                f"largest difference of a phi, {plant}",
                f"{most:g} deg at {most_at:g} s",
                f"{off.max():.1f} deg at {t[off.argmax()]:.1f} s",
                bool(abs(off.max() / most - 1) < _ROUNDED and abs(t[off.argmax()] - most_at) < 1.5 * (t[1] - t[0])),
            ),
            late if plant == "reduced" else not_essential(late),
            not_essential(_little(expected, float(off.max()), plant)),
        ]
    return checks


def _little(expected: Expected, off: float, plant: str) -> Check:
    return below(f"largest difference of a phi, which the paper calls little, {plant}", expected("little"), off, "deg")


def little_more_swing(runs: Runs, expected: Expected) -> Sequence[Check]:
    """Return the checks of claim 6: slightly more swing."""
    checks = []
    for plant, settings in _PLANTS:
        ratios = _ratios(runs, settings, "travel_phi1", "travel_phi2")
        off = float(np.degrees(_difference(runs, settings, "phi1", "phi2")).max())
        text = " / ".join(f"{ratio:.3f}" for ratio in ratios)
        more = Check(f"path of phi_1, phi_2 in 20 s, V2 over V1, {plant}", "> 1", text, min(ratios) > 1)
        checks += [more, _little(expected, off, plant)]
    return checks


def _ratios(runs: Runs, settings: Mapping[str, Any], *names: str) -> list[float]:
    """Return metrics under V2 over those under V1."""
    first, second = (runs.metrics(law, "paper", **settings) for law in LAWS)
    return [second[name] / first[name] for name in names]


def _speed(runs: Runs, expected: Expected) -> Sequence[Check]:
    def largest_loss(run: Run) -> float:
        return -float(np.diff(run.variables()["vx"]).min())

    slowest = [float(runs(law, "paper").variables()["ax"].min()) for law in LAWS]
    constant_ax = axial(runs(LAWS[0], "paper"))
    (gained,) = _gained(runs, expected, "full", FULL)
    constant = Check(
        "smallest a_x, full V1, V2",
        f"a_x of (19): {constant_ax:.4f} m/s^2",
        f"{slowest[0]:.3f} / {slowest[1]:.3f} m/s^2",
        min(slowest) > (1 - TIMES) * constant_ax,
    )
    return (
        _four(runs, "largest loss of v_x in 0.1 s", 0.0, "m/s", largest_loss),
        not_essential(constant),
        not_essential(gained),
    )


def turns(values: FloatArray, swing: float) -> int:
    """Count the turning points of a series, but for those of swings smaller than `swing`."""
    count, direction, turned = 0, 0, values[0]
    for value in values:
        if direction == 0 and abs(value - turned) > swing:
            direction, turned = (1 if value > turned else -1), value
        elif direction * (value - turned) > 0:
            turned = value
        elif direction * (turned - value) > swing:
            count, direction, turned = count + 1, -direction, value
    return count


def order_of_azimuths(runs: Runs, expected: Expected) -> Sequence[Check]:
    """Return the checks of claim 8, each over all four loops."""
    metrics = [runs.metrics(law, "paper", **settings) for law, settings in _LOOPS]
    late, early = (np.array([values[name] for values in metrics]) for name in ("t_theta1", "t_theta2"))
    swing = np.radians(expected("swing"))
    series = [runs(law, "paper", **settings).variables() for law, settings in _LOOPS]
    first, second = (np.array([turns(values[name], swing) for values in series]) for name in ("theta1", "theta2"))
    named, near = expected("theta1"), expected("near")
    turning = f"turning points of swings above {expected('swing'):g} degrees"

    def row(what: str, wanted: str, values: FloatArray, unit: str, holds: NDArray[np.bool_]) -> Check:
        return Check(f"{what} ({_ORDER})", wanted, f"{' / '.join(f'{v:.3g}' for v in values)}{unit}", bool(holds.all()))

    return (
        row(
            "theta_1 settles within 2 degrees of its end",
            f"{named:g} s within {100 * near:g} %",
            late,
            " s",
            abs(late / named - 1) < near,
        ),
        row(
            "theta_2 settles within 2 degrees of its end",
            f"≤ {expected('theta2'):g} s",
            early,
            " s",
            early <= expected("theta2"),
        ),
        row(
            "settling time of theta_1 over that of theta_2",
            f"> {expected('ratio'):g}",
            late / early,
            "",
            late > expected("ratio") * early,
        ),
        row(f"{turning} of theta_1", f"≥ {expected('turns'):g}", first, "", first >= expected("turns")),
        row(f"{turning} of theta_2", "fewer than of theta_1", second, "", second < first),
    )


def gained_speed(runs: Runs, expected: Expected) -> Sequence[Check]:
    """Return the check of claim 7 on the reduced model."""
    return _gained(runs, expected, "reduced", REDUCED)


def _gained(runs: Runs, expected: Expected, plant: str, settings: Mapping[str, Any]) -> Sequence[Check]:
    """Return the check that v_x has grown by a_x times the time."""
    run = runs(LAWS[0], "paper", **settings)
    vx = run.variables()["vx"]
    gain, full = float(vx[-1] - vx[0]), axial(run) * float(run.t[-1])
    near = expected("gain")
    return (about(f"v_x gained, {plant} V1", round(full), gain, "m/s", near),)


def better_law(runs: Runs, expected: Expected) -> Sequence[Check]:
    """Return the checks of claim 9."""
    checks = []
    for plant, settings in _PLANTS:
        path, settling, gimbal = (
            _ratios(runs, settings, names[0])[0] for names in (("travel_phi1",), ("t_phi1",), ("max_delta1",))
        )
        checks += [
            Check(f"path of phi_1 in 20 s, V1 over V2, {plant}", "< 1", f"{1 / path:.2f}", path > 1),
            Check(f"settling of phi_1, V1 over V2, {plant}", "< 1", f"{1 / settling:.3f}", settling > 1),
            not_essential(Check(f"largest |delta_1|, V1 over V2, {plant}", "< 1", f"{1 / gimbal:.2f}", gimbal > 1)),
        ]
    return checks


def _law_values(run: Run) -> FloatArray:
    return np.array([run.parameters.values[q.name] for q in run.controller.parameters])


def _along(runs: Runs, law: str, x: FloatArray, flow: FloatArray) -> float:
    """Return V' of a law along a direction, by central differences."""
    run, title = runs(law, "paper"), law.replace("-", "_")
    p, c = runs.model.parameters(), _law_values(run)
    ahead, behind = (runs.model.functions[f"{title}_value"](x + sign * _STEP * flow, p, c) for sign in (1, -1))
    return float((ahead - behind) / (2 * _STEP))


def values_fall(runs: Runs, expected: Expected) -> Sequence[Check]:
    """Return the checks of claim 10."""

    def rises(run: Run) -> float:
        title = run.controller.name.replace("-", "_")
        values = runs.model.functions[f"{title}_value"](run.x, runs.model.parameters(), _law_values(run))
        return float(np.count_nonzero(np.diff(values) >= 0))

    model, run = runs.model, runs("lyapunov-v1", "paper")
    x = model.state(vx=3000.0, phi1=0.5, phi1_dot=-0.1)
    flow = model.functions["lyapunov_v1_loop_reduced"](x, np.zeros(0), model.parameters(), _law_values(run))
    falling_back = _along(runs, "lyapunov-v1", x, np.asarray(flow))
    return (
        _four(runs, "samples at which V does not fall", 1, "", rises),
        not_essential(
            Check(
                "V1' at the goal with pendulum 1 at 0.5 rad, swinging back at 0.1 rad/s",
                "< 0",
                f"{falling_back:.3g} 1/s",
                falling_back < 0,
            )
        ),
    )


def _slope(runs: Runs, law: str, sign: float) -> Check:
    """Return the check that V falls on the full model, which to_physical makes follow any feasible u."""
    run, model = runs(law, "paper"), runs.model
    x, p = run.x[0], model.parameters()
    derived = np.asarray(model.functions[f"{law.replace('-', '_')}_demand"](x, p, _law_values(run)))[:5]
    demand = np.array([sign, sign, -1, -1, -1]) * -derived
    flow = model.rhs(x, model.functions["to_physical"](x, demand, p), p)
    slope, name, minus = _along(runs, law, x, flow), law[-2:].upper(), "-" if sign < 0 else ""
    text = f"{name}' at the start, with u_1 = {minus}w_1 B, u_2 = {minus}w_2 C"
    return Check(text, "< 0", f"{slope:.2e} 1/s", slope < 0)


def _weights_as_ordered(runs: Runs, expected: Expected) -> Sequence[Check]:
    small, large = expected("small"), expected("large")
    return positive(runs, **{f"r{k}": small for k in range(3, 9)}, r9=large, r10=large)


def _printed_signs(runs: Runs, expected: Expected) -> Sequence[Check]:
    return tuple(_slope(runs, "lyapunov-v2", sign) for sign in (1, -1))


def signs_restored(runs: Runs, expected: Expected) -> Sequence[Check]:
    """Return the checks of claim 11 with the minus signs, for both laws."""
    return tuple(_slope(runs, law, -1) for law in LAWS)


def lengths(runs: Runs, expected: Expected) -> Sequence[Check]:
    """Return the checks of claim 12."""
    moved: dict[str, float] = {}
    for law, settings in _LOOPS:
        read, literal = (runs.metrics(law, "paper", **settings, **more) for more in ({}, LENGTHS))
        for name in ("t_vy", "t_vz", "t_att", "t_phi1", "t_phi2", "t_theta1", "t_theta2"):
            moved[name] = max(moved.get(name, 0.0), abs(literal[name] - read[name]))
    azimuth, most = moved.pop("t_theta1"), expected("change")
    printed = ", ".join(f"{name} = {value:g}" for name, value in LENGTHS.items())
    return (
        below(f"largest change of a settling time with {printed}, all but theta_1", most, max(moved.values()), "s"),
        not_essential(below("change of the settling time of theta_1", most, azimuth, "s")),
    )


def attitude_settles(runs: Runs, expected: Expected, **weights: float) -> Sequence[Check]:
    """Return the check of claim 13 with weights and gains of the attitude."""
    end, bound = runs.metrics("lyapunov-v2", "paper", **weights)["t_att"], expected("settled")
    text = f"{end:.4g} s" if np.isfinite(end) else "does not settle"
    what = f"settling of the attitude within 0.1 degrees, r_3 = {weights['r3']:g}"
    return (Check(what, f"< {bound:g} s", text, end < bound),)


def _printed_weights(runs: Runs, expected: Expected) -> Sequence[Check]:
    weight = expected("weight")
    return attitude_settles(runs, expected, r3=weight, r5=weight, r7=weight)


CHECKS: Mapping[str, Checks] = {
    "1": _velocities,
    "2": _attitude,
    "3": _pendulum_angles,
    "4": _azimuths,
    "5": _same_motion_of_the_hull,
    "6": _more_swing,
    "7": _speed,
    "8": order_of_azimuths,
    "9": better_law,
    "10": values_fall,
    "11": _printed_signs,
    "12": lengths,
    "13": _printed_weights,
    "14": _weights_as_ordered,
}
"""Functions by the number of their claim in claims.toml."""
