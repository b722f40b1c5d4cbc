# SPDX-License-Identifier: Apache-2.0
"""A fixed sample of wrong equations, which the gates must notice; benchmarks/mutation.py tries all of them."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from mehvar.physics.machine import Machine, points
from mehvar.physics.mutation import run, weighted
from tests.mehvar.physics.declared import CRAFT, gates_of, title
from tests.mehvar.physics.installed import machine

SAMPLE = 60
CASES = (
    ("triangle", (("masses", "general"),)),
    ("triangle", (("masses", "general"), ("model", "dynamic"))),
    pytest.param(("satellite", (("chart", "quaternion"),)), marks=pytest.mark.soak),  # CRAFT has it too
    CRAFT,
    ("slosh", (("pendulums", "2"), ("inertia", "paper"))),
    ("slosh", (("pendulums", "1"), ("inertia", "hinge"))),
    ("slosh", (("pendulums", "2"), ("inertia", "ball"), ("attitude", "quaternion"))),
)


@pytest.mark.parametrize("case", CASES, ids=title)
@pytest.mark.share(8)
def test_no_wrong_term_passes(case):
    model, structure = case
    subject = machine(model, *structure)
    verdict = run(subject.system, subject.ranges, gates_of, SAMPLE)
    assert [f"{m.change} in {m.term.owner}: {m.term.text}" for m in verdict.survivors] == []
    assert verdict.killed + len(verdict.equivalent) == verdict.total == SAMPLE
    assert verdict.killed > 0.9 * SAMPLE


def test_weights_of_one_leave_the_equations():
    plain = machine("satellite")
    changed, terms = weighted(plain.system)
    subject = Machine(changed, plain.ranges, [term.weight for term in terms])
    for name in ("rhs", "outputs", "initial", "energy"):
        np.testing.assert_allclose(points(subject).call(name), points(plain).call(name), rtol=1e-13, atol=1e-14)


def test_without_gates_every_mutant_survives():
    subject = machine("satellite")
    verdict = run(subject.system, subject.ranges, lambda _: [], 12)
    assert len(verdict.survivors) == 12


def test_an_equation_that_does_not_pass_is_refused():
    system = machine("triangle").system
    wrong = dataclasses.replace(system, rhs=(*system.rhs[:3], -system.rhs[3]))
    with pytest.raises(ValueError, match=r"triangle: the unchanged equations fail .*angular momentum"):
        run(wrong, machine("triangle").ranges, gates_of, 1)
