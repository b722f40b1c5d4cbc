# SPDX-License-Identifier: Apache-2.0
"""A picture of the triangle shows the triangle."""

import numpy as np
import pytest

import mehvar


@pytest.mark.parametrize("phi", [-2.0, 0.4, 1.7])
def test_the_masses_are_as_far_apart_as_the_rods_are_long(phi):
    model = mehvar.load("triangle")
    x = model.state(rho=0.4, phi=phi, mu=0.17, theta=0.7)
    points = np.reshape(model.functions["geometry"](x, np.zeros(3), np.zeros(4), model.parameters()), (-1, 3))
    rods, masses = points[:6].reshape(3, 2, 3), points[6:9]
    lengths = model.functions["lengths"](0.4, phi, 0.17)
    assert np.linalg.norm(rods[:, 1] - rods[:, 0], axis=1) == pytest.approx(lengths, rel=1e-12)
    assert masses.mean(axis=0) == pytest.approx(np.zeros(3), abs=1e-15)
    turns = np.cross(masses[1] - masses[0], masses[2] - masses[0])
    assert turns[1] < 0  # counter-clockwise from the front, whose axis is -y
