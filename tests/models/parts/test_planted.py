# SPDX-License-Identifier: Apache-2.0
"""Wrong terms of parts, which balances and particles must notice; benchmarks/mutation.py tries all of them."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.mutation import reason
from mehvar.physics.machine import Machine, points

from .planted import craft, ranges_of, subjects
from .test_gates import bare

SUBJECTS = ("wheel", *(name for name in subjects() if name != "wheel"))
SAMPLE = 120
"""As many mutants as the wheel has; other parts have more."""


@pytest.mark.parametrize("name", SUBJECTS)
@pytest.mark.share(100)
def test_no_wrong_term_of_a_part_passes(name):
    verdict = subjects()[name].tally(SAMPLE)
    assert [f"{m.change} in {m.term.owner}: {m.term.text}" for m in verdict.survivors] == []
    assert "not proved" not in {reason(name, mutant) for mutant in verdict.equivalent}
    assert verdict.killed + len(verdict.equivalent) == verdict.total > 0


def test_weights_of_one_leave_a_craft():
    system, terms = craft(subjects()["torquer"].parts, "turn")
    subject = Machine(system, ranges_of(system), [term.weight for term in terms])
    at, plain = points(subject, 4), bare()
    for x, u, rates in zip(at.values["x"], at.values["u"], at.call("rhs"), strict=True):
        given = (dict(zip(names, values, strict=True)) for names, values in ((plain.x_names, x), (plain.u_names, u)))
        np.testing.assert_allclose(rates, list(plain.rates(*given).values()), rtol=1e-13, atol=1e-14)
