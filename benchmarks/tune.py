# SPDX-License-Identifier: Apache-2.0
"""Runs until `mehvar.tune` and samplers of Optuna reach a cost: four gains of a craft with three wheels.

python -m benchmarks.tune       in an environment with `optuna` and `cmaes`
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from importlib.metadata import version

import optuna

import mehvar
from benchmarks.machine import command_line, machine, table, write
from mehvar import Metric, Scenario
from mehvar.parts import Hub, Spacecraft, Wheel

RUNS, SEEDS, BUDGET = 256, 5, 40
"""Runs of a cost, the default of `tune`; repetitions of each sampler; its budget in multiples of the runs of `tune`."""
GAINS = [f"k{letter}_{axis}" for letter in "pd" for axis in "xy"]
VARY = {f"{angle}_0": "uniform(-0.5, 0.5)" for angle in ("roll", "pitch", "yaw")}
COST = "off + 2 * push"
NEAR = (0.1, 0.01, 0.001)
"""Parts of the improvement by `tune` that a sampler may still miss."""


def craft() -> mehvar.Model:
    """Return a rigid craft; the cost weighs the attitude error against the torque."""
    result = Spacecraft("gains", motion="attitude", period=0.2)
    result.add(Hub("hub", mass=40.0, inertia=(2.0, 3.0, 1.0)))
    for k, axis in enumerate("xyz"):
        result.add(Wheel(axis, axis=[float(k == i) for i in range(3)], inertia=0.01))

    def feedback(law):  # type: ignore[no-untyped-def]
        (_, *q), rates = law.attitude, law.rates
        stiff = [law.parameter(f"kp_{axis}", 0.1, "N m", bounds="(0, inf)") for axis in "xyz"]
        damp = [law.parameter(f"kd_{axis}", 0.5, "N m s", bounds="(0, inf)") for axis in "xyz"]
        return {axis: k * a + d * w for axis, k, a, d, w in zip("xyz", stiff, q, damp, rates, strict=True)}

    result.law("feedback", feedback)
    torques = tuple(f"u_{axis}_torque" for axis in "xyz")
    return mehvar.build(
        lambda: result.system(
            scenarios=(Scenario("turn", "to inertial axes", 40.0, 0.2),),
            metrics=(
                Metric("off", "rms", ("q1", "q2", "q3"), "1", "half the angle"),
                Metric("push", "rms", torques, "N m", "torque"),
            ),
        )
    )


def searched(
    model: mehvar.Model, sampler: optuna.samplers.BaseSampler, start: dict[str, float], most: int, goal: float
) -> list[float]:
    """Return the best cost after each trial, until the goal."""
    best: list[float] = []

    def cost(trial: optuna.Trial) -> float:
        gains = {name: trial.suggest_float(name, value / 30, value * 30, log=True) for name, value in start.items()}
        runs = mehvar.batch(model, "feedback", RUNS, vary=VARY, parameters=gains, seed=0)
        value = float((runs["off"] + 2 * runs["push"]).mean())
        value = value if math.isfinite(value) else 1e3
        best.append(min([value, *best[-1:]]))
        return value

    study = optuna.create_study(sampler=sampler)
    study.enqueue_trial(start)
    study.optimize(cost, n_trials=most, callbacks=[lambda study, _trial: study.stop() if best[-1] <= goal else None])
    return best


def main() -> None:
    """Measure and write the page."""
    command_line(__doc__).parse_args()
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    warnings.simplefilter("ignore")
    model = craft()
    tuned = mehvar.tune(model, "feedback", GAINS, COST, vary=VARY, n=RUNS)
    first, last = tuned.cost
    trials = BUDGET * tuned.runs // RUNS
    samplers: dict[str, Callable[[int], optuna.samplers.BaseSampler]] = {
        "TPE, the default": lambda seed: optuna.samplers.TPESampler(seed=seed),
        "CMA-ES": lambda seed: optuna.samplers.CmaEsSampler(seed=seed, x0=dict(tuned.start)),
    }
    goals, rows = [last + part * (first - last) for part in NEAR], []
    for name, sampler in samplers.items():
        found = [searched(model, sampler(seed), dict(tuned.start), trials, goals[-1]) for seed in range(SEEDS)]
        cells = []
        for goal in goals:
            needed = sorted(next((k for k, c in enumerate(best, 1) if c <= goal), math.inf) for best in found)
            middle = needed[SEEDS // 2]
            ratio = middle * RUNS / tuned.runs
            cells.append(f"{ratio:.1f}" if math.isfinite(middle) else f"more than {BUDGET}")
        rows.append([name, *cells, f"{min(best[-1] for best in found):.6f}"])
    lines = [
        "# Tuning beside Optuna", "",
        f"Written by `python -m benchmarks.tune`. Four gains, mean cost of {RUNS} dispersed runs, equal in each trial;",
        f"Optuna {version('optuna')} searches within a factor 30 of the same start, {SEEDS} seeds each, medians.", "",
        "## Machine", "", *machine(), "", "## Runs", "",
        f"`mehvar.tune` improves the cost from {first:.6f} to {last:.6f} in {tuned.runs} runs. The table has the runs",
        "of Optuna, in multiples of this number, until it misses a part of this improvement.", "",
        *table(("sampler", *(f"misses {part:.1%}" for part in NEAR), "best cost of all"), rows),
    ]  # fmt: skip
    write("tune.md", lines)


if __name__ == "__main__":
    main()
