# SPDX-License-Identifier: Apache-2.0
"""Every sensor shows the truth where its noise is at its mean, and noise is as strong at any sample period."""

import dataclasses

import numpy as np
import pytest

from mehvar.physics.gates import MEASUREMENTS, TOLERANCE
from mehvar.physics.machine import Machine, points
from tests.mehvar.physics.declared import CASES, CRAFT, gates_of, title
from tests.mehvar.physics.installed import machine
from tests.sampling import RANGES

SATELLITES = [case for case in CASES if case[0] == "satellite"]


def subject_of(case):
    model, structure = case
    return machine(model, *structure)


@pytest.mark.parametrize("case", CASES, ids=title)
@pytest.mark.share(12)
def test_every_sensor_has_a_gate(case):
    subject = subject_of(case)
    assert (subject.system.sensor is not None) == (MEASUREMENTS in {gate.name for gate in gates_of(subject)})


@pytest.mark.parametrize("case", SATELLITES, ids=title)
@pytest.mark.share(4)
def test_an_instrument_that_is_off_by_its_noise_is_noticed(case):
    """Each measured quantity in turn is off by the size of each noise, as it would be at one sigma all the time."""
    subject = subject_of(case)
    sensor, p = subject.system.sensor, subject.system.parameters
    gate = next(gate for gate in gates_of(subject) if gate.name == MEASUREMENTS)
    assert gate.error(points(subject)) <= TOLERANCE
    sizes = [q.symbol for q in p if "noise" in q.name]
    assert len(sizes) >= 2
    for k, row in enumerate(sensor.measured):
        measured = (*sensor.measured[:k], row + sizes[k % len(sizes)], *sensor.measured[k + 1 :])
        wrong = dataclasses.replace(subject.system, sensor=dataclasses.replace(sensor, measured=measured))
        assert gate.error(points(Machine(wrong, RANGES["satellite"]))) > 1e-3, row


@pytest.mark.parametrize("case", SATELLITES, ids=title)
@pytest.mark.share(12)
def test_only_densities_know_the_sample_period(case):
    """Each noise in turn: what is per root of a second has ten times the effect at a hundredth of the period."""
    subject = subject_of(case)
    names = [q.name for q in subject.system.parameters if "noise" in q.name]
    units = {q.name: q.unit for q in subject.system.parameters}
    at = points(subject).moved(quantum=0.0, **dict.fromkeys(names, 0.0))
    ones = np.ones((len(at["Ts"]), len(subject.system.sensor.noise)))
    for name in names:
        few = at.moved(**{name: 1e-6})
        effects = [
            subject("measure", there.values["x"], ones, there.values["p"])
            - subject("measure", there.values["x"], 0 * ones, there.values["p"])
            for there in (few.moved(Ts=0.5), few.moved(Ts=0.005))
        ]
        scale = 10 if "^(1/2)" in units[name] else 1
        assert np.abs(effects[0]).max() > 1e-9
        np.testing.assert_allclose(effects[1], scale * effects[0], rtol=1e-3, atol=1e-13)


def allan(rates, size):
    """Return the Allan deviation of rates over clusters of samples, which do not overlap."""
    means = rates[: len(rates) // size * size].reshape(-1, size).mean(axis=1)
    return np.sqrt(np.mean(np.diff(means) ** 2) / 2)


STRONG = 2e-3
SIZE, CLUSTERS = 20, 4000
"""rad/s^(1/2); samples of a cluster, and clusters."""


@pytest.mark.parametrize("period", [0.5, 0.05])
@pytest.mark.share(2)
def test_densities_are_what_a_data_sheet_prints(period):
    """The Allan deviation N/sqrt(tau) of white noise (IEEE 952), at two sample periods.

    Of 4000 clusters the deviation is off by 1/sqrt(2 * 4000) of itself, one percent; five are allowed.
    """
    subject, rng = subject_of(CRAFT), np.random.default_rng(5)
    count, cluster = CLUSTERS * SIZE, SIZE * period
    at = points(subject, 1).moved(noise_rate=STRONG, Ts=period, noise=0.0, quantum=0.0)
    x, p = at.values["x"], at.values["p"]
    place = [q.name for q in subject.system.states].index("wx")
    e = rng.standard_normal((count, len(subject.system.sensor.noise)))
    seen = subject("measure", np.repeat(x, count, axis=0), e, np.repeat(p, count, axis=0))
    assert allan(seen[:, place], SIZE) == pytest.approx(STRONG / np.sqrt(cluster), rel=0.05)
