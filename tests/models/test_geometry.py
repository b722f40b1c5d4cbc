# SPDX-License-Identifier: Apache-2.0
"""A system's geometry: what is refused of it, and that its points are where its expressions say."""

from dataclasses import replace

import numpy as np
import pytest
import sympy as sp

from mehvar.cli.new import scaffold
from mehvar.codegen.functions.requests import requests
from mehvar.codegen.generate import Tree, system_of
from mehvar.models.check import check
from mehvar.models.quantities import ModelError
from mehvar.models.system import Shape
from mehvar.report.scene import points, scene
from mehvar.runtime.model.model import load
from mehvar.runtime.run.results import to_dataset
from mehvar.runtime.run.simulate import simulate
from tests.models.edits import cart

O = (sp.S.Zero, sp.S.Zero, sp.S.Zero)  # noqa: E741 - the origin


@pytest.fixture(scope="module")
def project(tmp_path_factory):
    return scaffold("flywheel", tmp_path_factory.mktemp("geometry"))


@pytest.fixture(scope="module")
def system(project):
    return system_of(Tree(project), "flywheel", {})


@pytest.mark.parametrize(
    ("shapes", "message"),
    [
        ((Shape("a", "stick", (O, O)),), "kind = 'stick': must be rod, arrow, ball, box or face"),
        ((Shape("a", "rod", (O, O), "teal"),), "color = 'teal': must be blue, vermillion"),
        ((Shape("a", "rod", (O,)),), "has 1 points: a rod must have 2 or more"),
        ((Shape("a", "box", (O, O, O)),), "has 3 points: a box must have 4"),
        ((Shape("a", "ball", (O,)), Shape("a", "rod", (O, O))), "shape 'a' is defined twice"),
        ((Shape("a", "ball", ((sp.Symbol("stranger"), *O[1:]),)),), "'stranger' belongs to no group"),
        ((Shape("a", "ball", ((sp.oo, *O[1:]),)),), "numbers must be real and finite"),
        ((Shape("a", "ball", (O[:2],)),), "must be a tuple of 3"),
    ],
)
def test_what_no_picture_can_draw_is_refused_with_its_line(system, shapes, message):
    with pytest.raises(ModelError, match=message) as refused:
        check(replace(system, geometry=shapes))
    assert ".py:" in str(refused.value)


def test_units_are_those_of_the_picture(system):
    check(replace(system, geometry=(Shape("a", "ball", ((system.states.wheel + 1, *O[1:]),)),)))


def test_points_are_where_the_expressions_say(project):
    """The rod of `mehvar new` is as long as the parameter says, and points where the angle does; also beside a run."""
    model = load(project / "generated" / "flywheel")
    run = to_dataset(simulate(model, "balance", l=0.3))
    drawn, places = scene({"run": run}, model), points(run, model).T
    names = [shape["name"] for shape in drawn["shapes"]]
    assert names == ["pivot", "pendulum", "flywheel", "rate of the flywheel"]
    theta = run["theta"].values
    assert np.allclose(places[6], 0.3 * np.sin(theta))  # x and z of the rod's second point
    assert np.allclose(places[8], -0.3 * np.cos(theta))
    assert np.allclose(places[16] - places[13], 0.005 * run["wheel"].values)
    assert drawn["speeds"][0] == 0.5


def test_a_system_without_a_geometry_has_no_such_function():
    assert "geometry" not in [request.name for request in requests(cart())]
