# SPDX-License-Identifier: Apache-2.0
"""Source of a parameter, messages about it, and refused combinations."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mehvar import runtime
from mehvar.base.manifest import FILE
from mehvar.runtime import InputError, Model
from mehvar.runtime.model.parameters import Resolved, elements, resolve, say


@pytest.fixture(params=["c", "python"])
def model(request: pytest.FixtureRequest, pendulum: Model, slow_pendulum: Model) -> Model:
    return pendulum if request.param == "c" else slow_pendulum


def resolved(model: Model, law: str = "pd", scenario: str = "swing", **values: Any) -> Resolved:
    manifest = model.manifest
    return resolve(
        manifest,
        model.functions,
        manifest.controller(law),
        manifest.scenario(scenario),
        values,
        "--set",
        ["delay", "hold"],
    )


MATRICES = ("K_1_1", "K_1_2", "K_2_1", "K_2_2", "J_1_1", "J_1_2", "J_2_2", "v_1", "v_2", "m")
"""A matrix, a symmetric one, a vector and a number."""


def test_an_array_stands_as_its_elements() -> None:
    given = {"K": [[1, 2], [3, 4]], "J": np.array([[5.0, 6.0], [6.0, 7.0]]), "v": (8, 9), "m": 10.0}
    assert elements(given, MATRICES) == dict(zip(MATRICES, (1, 2, 3, 4, 5, 6, 7, 8, 9, 10), strict=True))


def test_a_number_in_the_place_of_an_array_stays_what_was_given() -> None:
    """Whoever looks its name up says that there is none."""
    assert elements({"K": 1.0, "v": "2", "v_1": 3.0}, MATRICES) == {"K": 1.0, "v": "2", "v_1": 3.0}


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        *((name, value, f"an array with the elements {name}_1")
          for name, value in (("K", [1, 2]), ("v", [1, 2, 3]), ("v", [[1, 2]]), ("J", [[1, 2]]))),
        ("J", [[1, 2], [3, 4]], "symmetric: J_2_1 and J_1_2 differ"),
    ],
)  # fmt: skip
def test_an_array_of_another_shape_is_refused(name: str, value: list[Any], message: str) -> None:
    with pytest.raises(InputError, match=rf"{name} = .* \(from here\): must be {message}"):
        elements({name: value}, MATRICES, "here")


def test_defaults(model: Model) -> None:
    vectors = resolved(model)
    np.testing.assert_array_equal(vectors.p, model.parameters())
    np.testing.assert_allclose(vectors.c, [20.0, 2 * np.sqrt(20.0)])
    np.testing.assert_array_equal(vectors.s, [1.0, 0.0, 0.5, 0.0])
    assert vectors.origins["m"] == "default"
    assert vectors.origins["k_d"] == "formula 2*sqrt(k_p)"


def test_who_comes_first(model: Model) -> None:
    vectors = resolved(model, scenario="stiff", rate_0=0.1)
    assert (vectors.values["k_p"], vectors.origins["k_p"]) == (40.0, "scenario stiff, pd")
    assert (vectors.values["angle_0"], vectors.origins["angle_0"]) == (0.8, "scenario stiff")
    assert (vectors.values["rate_0"], vectors.origins["rate_0"]) == (0.1, "--set")
    assert resolved(model, "p-sum", "stiff").values["k_p"] == 30.0
    assert resolved(model, "pd", "stiff", k_p=50.0).values["k_p"] == 50.0


def test_formula_follows_what_is_set(model: Model) -> None:
    assert resolved(model, k_p=25.0).values["k_d"] == pytest.approx(10.0)
    assert resolved(model, k_p=25.0, k_d=3.0).values["k_d"] == 3.0
    assert resolved(model, scenario="stiff").values["k_d"] == pytest.approx(2 * np.sqrt(40.0))


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"k_q": 1.0}, r"'k_q' of pendulum with pd \(from --set\): did you mean k_p or k_d"),
        ({"angel_0": 1.0}, "did you mean angle_0"),
        ({"dely": 1.0}, "did you mean delay"),
        ({"rate_mx": 1.0}, "did you mean rate_max"),
        ({"m": -2}, r"m = -2.0 \(from --set\): must be in \(0, inf\) kg"),
        ({"k_p": float("nan")}, r"k_p = nan \(from --set\): must be a finite number"),
        ({"angle_0": "up"}, r"angle_0 = 'up' \(from --set\): must be a number"),
        ({"k_d": None}, r"k_d = None \(from --set\): must be a number"),
    ],
)
def test_bad_values(model: Model, values: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        resolved(model, **values)


def test_constraints_show_values_and_origins(model: Model) -> None:
    with pytest.raises(InputError, match=r"k_p = 5 must be larger .* m = 1 kg \(k_p from --set, m from default\)"):
        resolved(model, k_p=5.0)
    with pytest.raises(InputError, match=r"angle_0 = 3.2 rad must be within half a turn \(angle_0 from --set\)"):
        resolved(model, angle_0=3.2)
    assert resolved(model, "p-sum", k_p=5.0).values["k_p"] == 5.0


def test_bad_value_of_a_scenario_names_the_scenario(edited: Callable[[str, str, str], Path]) -> None:
    copy = edited(FILE, '"controllers": {"pd": {"k_p": 40.0}}', '"controllers": {"pd": {"k_p": -40.0}}')
    with pytest.raises(InputError, match=r"k_p = -40.0 \(from scenario stiff, pd\): must be in \(0, inf\) N m"):
        resolved(runtime.load(copy, backend="python"), scenario="stiff")


def test_parameter_without_default_must_be_set(edited: Callable[[str, str, str], Path]) -> None:
    model = runtime.load(
        edited(FILE, '"name": "m", "unit": "kg", "default": 1.0', '"name": "m", "unit": "kg", "default": null'),
        backend="python",
    )
    with pytest.raises(InputError, match=r"m has no default: set it to a value in \(0, inf\) kg"):
        resolved(model)
    assert resolved(model, m=1.5).values["m"] == 1.5


def test_messages_are_filled_in() -> None:
    assert say("R = {R} and {R:.2f}", {"R": 1 / 3}) == "R = 0.333333 and 0.33"
    assert say("{unknown} stays", {"R": 1.0}) == "{unknown} stays"
