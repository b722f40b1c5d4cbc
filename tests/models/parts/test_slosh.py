# SPDX-License-Identifier: Apache-2.0
"""The plant of slosh beside the one assembled from parts.

The reduced plant (20)-(26) is an approximation of the paper, which no assembly of parts is.
"""

from __future__ import annotations

import dataclasses
import itertools

import pytest
import sympy as sp

from mehvar.codegen.diff.report import ModelStatus
from mehvar.models.slosh import STRUCTURE

from .shipped import slosh
from .shipped.rederived import Side, bare, mutant, structured

CHOICES = [STRUCTURE[name] for name in ("inertia", "attitude")]

MOST_IN_DIFF = 3
"""Pendulums up to which `diff` compares whole documents; it takes 10 s for three and 45 s for eight."""


@pytest.mark.parametrize(
    "structure", [("2", "paper", "angles"), ("1", "hinge", "quaternion"), ("1", "ball", "quaternion")], ids="-".join
)
def test_the_rates_of_slosh_are_those_of_its_parts(structure):
    """As functions of states, inputs and parameters: in a finite field, where nothing rounds."""
    assert [name for pair in slosh.forms(*structure) for name in pair.differences()] == []


def test_small_angles_change_only_the_rates_of_the_attitude():
    """They are the paper's approximation: the rates of the hub."""
    small = structured("slosh")
    (euler,) = (v.rhs for v in small.variants if v.values == ("full", "euler"))
    rows = zip((q.name for q in small.states), small.rhs, euler, strict=True)
    other = {name: str(rate) for name, rate, full in rows if rate != full}
    assert other == {"att1": "wx", "att2": "wy", "att3": "wz"}


def test_located_switches_leave_the_rates():
    one = {"pendulums": "1", "inertia": "hinge", "attitude": "quaternion"}
    crossed, located = (bare(structured("slosh", **one, switches=s)) for s in STRUCTURE["switches"])
    assert (located.rhs, located.steps) == (crossed.rhs, crossed.steps)


@pytest.mark.parametrize(
    ("structure", "name", "factor"),
    [
        (("2", "paper", "angles"), "stream_z", -1),
        (("2", "paper", "angles"), "bob1_Q2", 2),
        (("1", "hinge", "quaternion"), "bob1_W2_z", -1),
        (("1", "ball", "quaternion"), "bob1_T0", 2),
    ],
)
def test_a_wrong_term_of_a_part_is_refused(structure, name, factor):
    pair = slosh.forms(*structure)[0]
    wrong = Side(mutant(pair.assembled.system, name, factor), pair.assembled.at)
    differences = dataclasses.replace(pair, assembled=wrong).differences()
    assert {"vx'", "vy'", "vz'"} & {*differences}


@pytest.mark.soak
def test_diff_calls_a_wrong_form_changed():
    pair = slosh.named(bare(structured("slosh", pendulums="1", inertia="ball", attitude="quaternion")))
    assert pair.verdict() is ModelStatus.SAME
    wrong = Side(pair.assembled.system, {**pair.assembled.at, "eps1": -sp.Symbol("eps1", real=True)})
    assert dataclasses.replace(pair, assembled=wrong).verdict() is ModelStatus.CHANGED


@pytest.mark.soak
@pytest.mark.parametrize("structure", [*itertools.product(("1", "2", "3", "8", "64"), *CHOICES)], ids="-".join)
def test_diff_calls_every_structure_of_slosh_the_same(structure):
    """With laws and functions; on a chart of the bobs' directions, the rates alone."""
    for pair in slosh.forms(*structure):
        assert pair.differences() == []
        assert int(structure[0]) > MOST_IN_DIFF or pair.verdict() is ModelStatus.SAME
