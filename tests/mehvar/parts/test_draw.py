# SPDX-License-Identifier: Apache-2.0
"""Pictures of crafts that are not built."""

import numpy as np
import pytest

from mehvar import MehvarError
from mehvar.parts import Bob, Gyro, Hinge, Hub, Spacecraft, Thruster, Wheel


@pytest.fixture
def survey(monkeypatch):
    """A craft whose equations must not be derived."""
    craft = Spacecraft("survey", "a survey craft")
    craft.add(Hub("hub", mass=120.0, inertia=(12.0, 14.0, 10.0)))
    craft.add(Wheel("wheel", axis=(0, 0, 1), inertia=0.02, torque_limit=0.1, speed_limit=50.0))
    craft.add(Hinge("panel", mass=8.0, inertia=(1.0, 0.1, 1.0), axis=(0, 0, 1), at=(0, 0.5, 0), centre=(0, 0.9, 0)))
    craft.add(Bob("tank", mass=20.0, length=0.25, at=(0, 0, -0.3), rest=(0, 0, -1)))
    craft.add(Thruster("jet", direction=(1, 0, 0), at=(-0.3, 0, 0), limit=2.0))
    craft.add(Gyro("gyro"))
    monkeypatch.setattr(Spacecraft, "system", None)
    return craft


def labels(figure):
    """Return the places of the labels by their texts."""
    (ax,) = figure.axes
    return {text.get_text().strip(): text.get_position_3d() for text in ax.texts if hasattr(text, "get_position_3d")}


def test_parts_have_their_names_at_their_mounts(survey):
    figure = survey.draw()
    at = labels(figure)
    assert set(at) - {""} == {"hub", "x", "y", "z", "wheel", "panel", "tank", "jet", "centre of mass"}
    assert np.allclose(at["panel"], (0, 0.5, 0))
    assert np.allclose(at["tank"], (0, 0, -0.3))
    assert np.allclose(at["centre of mass"], (0, 8 * 1.4 / 148, -20 * 0.55 / 148))
    assert [text.get_text() for text in figure.axes[0].texts][-1] == "without a shape: gyro"
    assert figure.axes[0].get_title() == "a survey craft"


def test_values_move_parts(survey):
    assert np.allclose(labels(survey.draw(panel_angle=np.pi / 2))["centre of mass"][:2], (-8 * 0.9 / 148, 4 / 148))


def test_what_cannot_be_drawn_is_refused(survey):
    with pytest.raises(MehvarError, match=r"survey: quantity 'panel_angel' is not known \(did you mean 'panel_angle'"):
        survey.draw(panel_angel=1.0)
    with pytest.raises(MehvarError, match=r"panel_angle = 'wide': must be a number"):
        survey.draw(panel_angle="wide")
    with pytest.raises(MehvarError, match=r"panel_m = 0.0: must be a number in \(0, inf\), kg"):
        survey.draw(panel_m=0.0)
    with pytest.raises(MehvarError, match="none has no parts: add a Hub first"):
        Spacecraft("none").draw()


def test_a_craft_in_orbit_is_drawn():
    from mehvar.parts import GravityGradient, Magnetorquer, Orbit

    craft = Spacecraft("polar", orbit=Orbit("J2", size=6.9e6, inclination=1.7))
    craft.add(Hub("hub", mass=12.0, inertia=(0.2, 0.25, 0.1)))
    craft.add(GravityGradient())
    craft.add(Magnetorquer("coil", axis=(1, 0, 0), limit=0.4))
    assert np.allclose(labels(craft.draw())["centre of mass"], 0)
