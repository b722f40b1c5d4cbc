# SPDX-License-Identifier: Apache-2.0
"""The satellite beside the one assembled from library parts, in inertial axes on a circular orbit."""

from __future__ import annotations

import dataclasses
import itertools

import pytest
import sympy as sp

from mehvar.codegen.diff.report import ModelStatus
from mehvar.models.satellite import STRUCTURE

from .shipped import satellite
from .shipped.rederived import Side, bare, mutant, structured


@pytest.mark.parametrize("structure", [("euler", "principal", "axes"), ("quaternion", "full", "any")], ids="-".join)
def test_the_rates_of_the_satellite_are_those_of_its_parts(structure):
    """Also for torques from outside, wheels = 0, as the share of the wheels is a parameter."""
    assert satellite.forms(*structure).differences() == []


def test_the_circular_orbit_is_one_of_the_library():
    """The library's gravity gradient also pushes the satellite along its orbit, which the paper neglects."""
    shipped = structured("satellite")
    for gradient, differences in ((False, []), (True, ["velocity1'", "velocity2'", "velocity3'"])):
        pair = satellite.pair(shipped, satellite.assembled(shipped, gradient))
        moving = dataclasses.replace(pair, readings=satellite.velocity(shipped))
        assert moving.differences() == differences


@pytest.mark.parametrize(("name", "factor"), [("gradient_Jnz", -1), ("wheelx_S1rx", 2), ("total_Hy", -1)])
def test_a_wrong_term_of_a_part_is_refused(name, factor):
    pair = satellite.forms("euler", "principal", "axes")
    wrong = Side(mutant(pair.assembled.system, name, factor), pair.assembled.at)
    assert {"wx'", "wy'"} & {*dataclasses.replace(pair, assembled=wrong).differences()}


@pytest.mark.soak
def test_diff_calls_a_wrong_form_changed():
    pair = satellite.forms("euler", "principal", "axes")
    pair = dataclasses.replace(pair, shipped=Side(bare(pair.shipped.system)))
    assert pair.verdict() is ModelStatus.SAME
    wrong = Side(pair.assembled.system, {**pair.assembled.at, "Iw_x": 2 * sp.Symbol("Iw_x", positive=True)})
    assert dataclasses.replace(pair, assembled=wrong).verdict() is ModelStatus.CHANGED


@pytest.mark.soak
@pytest.mark.parametrize("structure", [*itertools.product(*STRUCTURE.values())], ids="-".join)
def test_diff_calls_every_structure_of_the_satellite_the_same(structure):
    """With laws and functions: rates and momenta in place of the shipped ones; on unit quaternions, the rates alone."""
    pair = satellite.forms(*structure)
    assert pair.differences() == []
    assert pair.verdict() is ModelStatus.SAME
    assert dataclasses.replace(pair, shipped=Side(pair.shipped.system)).verdict() is ModelStatus.SAME
