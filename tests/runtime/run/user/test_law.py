# SPDX-License-Identifier: Apache-2.0
"""A law as a Python function: the same loop as under a generated law, and every wrong return refused by name."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from mehvar import runtime
from mehvar.base.errors import InputError, MehvarError
from mehvar.runtime.run.user.law import LawError
from mehvar.runtime.run.user.state import state_type

K_P, K_I, TS = 2.0, 0.5, 0.05


def p_sum(_t, x, z):
    """The pendulum's sampled law, written again."""
    error = x.angle - x.angle_ref
    return -K_P * error - K_I * z, z + error


def run(model: runtime.Model, law: Any = p_sum, **options: Any) -> runtime.Run:
    return runtime.simulate(model, law, **{"period": TS, "memory": [0.25], **options})


@pytest.fixture(scope="module")
def generated(pendulum: runtime.Model) -> runtime.Run:
    return runtime.simulate(pendulum, "p-sum", parameters={"Ts": TS})


def test_the_same_law_in_python_gives_the_same_bits(pendulum: runtime.Model, generated: runtime.Run) -> None:
    own = run(pendulum)
    for name in ("t", "x", "u", "u_cmd", "y", "z"):
        np.testing.assert_array_equal(getattr(own, name), getattr(generated, name), name)
    assert (own.controller.name, own.controller.title) == ("python:p_sum", "The pendulum's sampled law, written again.")
    assert own.options["hold"] == TS


def test_without_a_compiler_it_agrees_to_rounding(slow_pendulum: runtime.Model, generated: runtime.Run) -> None:
    own = run(slow_pendulum)
    assert own.backend == "python"
    np.testing.assert_allclose(own.x, generated.x, rtol=0, atol=1e-9)


@pytest.mark.parametrize("method", ["dop853", "rk4", "rodas5p"])
def test_a_continuous_law_is_evaluated_for_every_slope(
    pendulum: runtime.Model, slow_pendulum: runtime.Model, method: str
) -> None:
    generated = runtime.simulate(pendulum, "pd", t_end=1.0, method="rk4" if method == "rk4" else "dop853")
    k_p, k_d = generated.parameters.c

    def law(_t, x):
        return [-k_p * (x.angle - x.angle_ref) - k_d * x.rate]

    for model, backend in ((pendulum, "c"), (slow_pendulum, "python")):
        own = runtime.simulate(model, law, t_end=1.0, method=method)
        assert (own.backend, own.hold) == (backend, None)
        np.testing.assert_allclose(own.x, generated.x, rtol=0, atol=1e-8)


def test_an_exception_in_a_continuous_law_ends_the_run(pendulum: runtime.Model) -> None:
    def law(t, x):
        return 1 / (t < 0.5) * x.angle

    with pytest.raises(LawError, match=r"the law law at t = 0\.5.* raised ZeroDivisionError"):
        runtime.simulate(pendulum, law, t_end=1.0)


def test_a_delay_and_a_limit_hold_for_it_too(pendulum: runtime.Model) -> None:
    late = run(pendulum, delay=1)
    np.testing.assert_array_equal(late.u[:5], 0.0)
    np.testing.assert_array_equal(late.u[5::5][:-1], late.u_cmd[:-1:5][: len(late.u[5::5][:-1])])
    lost = runtime.simulate(pendulum, lambda t, _x: 1e9 * (t > 0.1), period=TS)
    assert lost.status is runtime.Status.LIMIT
    assert lost.t_stop == pytest.approx(0.15)


def test_the_law_sees_time_names_and_references_and_can_change_nothing(pendulum: runtime.Model) -> None:
    instants = []

    def law(t, x):
        instants.append(t)
        assert x.shape == (2,)
        assert (x.angle, x.rate) == (x[0], x[1]) == (x["angle"], x["rate"])
        assert x.angle_ref == x["angle_ref"] == x.r[0]
        for array in (x, x.r):
            with pytest.raises(ValueError, match="read-only"):
                array[0] = 1.0
        return np.array([0.0])

    run(pendulum, law, memory=None, t_end=0.2)
    assert instants == [0.0, 0.05, 0.1, 0.15, 0.2]


def test_a_part_of_a_state_is_a_plain_array() -> None:
    x = np.array([1.0, 2.0, 3.0]).view(state_type(("a", "b", "T"), ("ref",)))
    x.r = np.array([5.0])
    assert (x.a, x.T, x.ref, x["T"]) == (1.0, 3.0, 5.0, 3.0)
    for part in (x[:2], 2 * x, np.sin(x), np.eye(3) @ x, x[[2, 0]]):
        assert type(part) is np.ndarray
    assert type(x @ x) is np.float64
    with pytest.raises(InputError, match="unknown state or reference 'aa': did you mean a"):
        x["aa"]


class Broken:
    """A law that goes wrong at 0.1 s in one of many ways."""

    def __init__(self, wrong: Any) -> None:
        self.wrong = wrong

    def __call__(self, t, x, z):
        if t < 0.1:
            return [0.0], z
        return self.wrong(x, z) if callable(self.wrong) else self.wrong


def fails(_x, _z):
    raise ZeroDivisionError("division by nothing")


def in_place(_x, z):
    z += 1
    return [0.0], z


def to_the_state(x, z):
    x[0] = 0.0
    return [0.0], z


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (fails, "raised ZeroDivisionError: division by nothing"),
        (in_place, "read-only.*cannot be changed in place: return the input and"),
        (to_the_state, "read-only.*cannot be changed in place"),
        (([np.nan], [0.0]), r"returned u = \[nan\]: must be finite numbers, one for each of torque"),
        (([np.inf], [0.0]), r"returned u = \[inf\]: must be finite"),
        (([0.0], [np.nan]), r"returned z_next = \[nan\]: must be finite"),
        (([0.0, 0.0], [0.0]), r"returned u = \[0.0, 0.0\]: must be numbers of shape \(1,\), one for each of torque"),
        ((np.zeros((1, 2)), [0.0]), r"of shape \(1, 2\): must be numbers of shape \(1,\)"),
        (([0.0], [0.0, 0.0]), r"returned z_next = \[0.0, 0.0\]: must be numbers of shape \(1,\)"),
        ((["1"], [0.0]), r"returned u = \['1'\]: must be numbers"),
        (("1", [0.0]), "returned u = '1': must be numbers"),
        (([True], [0.0]), r"returned u = \[True\]: must be numbers"),
        (([1j], [0.0]), "must be numbers"),
        ((None, [0.0]), "returned u = None"),
        (([[0.0], [0.0, 1.0]], [0.0]), "must be numbers of shape"),
        (None, "returned None: must be the pair"),
        ([0.0], r"returned \[0.0\]: must be the pair"),
    ],
)
def test_what_a_law_does_wrong_is_said_with_time_and_value(pendulum: runtime.Model, wrong: Any, message: str) -> None:
    with pytest.raises(LawError, match=f"^the law Broken at t = 0.1 s .*{message}") as error:
        run(pendulum, Broken(wrong))
    assert isinstance(error.value, MehvarError)
    assert error.value.exit_status == 3


def test_the_place_in_the_law_is_said(pendulum: runtime.Model) -> None:
    def law(_t, x):
        return x.rat

    with pytest.raises(LawError, match=rf"'rat' .* \({__file__}, line {law.__code__.co_firstlineno + 1}\)"):
        run(pendulum, law, memory=None)


def test_an_interrupt_in_a_law_is_not_its_error(pendulum: runtime.Model) -> None:
    def law(_t, _x):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(pendulum, law, memory=None)


@pytest.mark.parametrize(
    ("controller", "arguments", "message"),
    [
        (p_sum, {"period": None}, r"memory = \[0.25\].*left out unless the law has a period"),
        (p_sum, {"memory": []}, "memory = .*a list of finite numbers"),
        (p_sum, {"memory": [np.nan]}, "memory = .*a list of finite numbers"),
        (p_sum, {"memory": 1.0}, "memory = 1.0.*a list of finite numbers"),
        (p_sum, {"memory": ["a"]}, "memory = .*a list of finite numbers"),
        (p_sum, {"period": 0.0}, r"hold = 0.0 \(from the call, period\): must be a number > 0"),
        (p_sum, {"hold": 0.05}, "hold = 0.05.*use period for other laws"),
        (p_sum, {"inputs": {}}, "inputs = .*left out with a law"),
        (p_sum, {"k_p": 3.0}, "unknown parameter or option 'k_p' of pendulum with python:p_sum"),
        ("pd", {"memory": None}, "period = 0.05.*hold says"),
        ("pd", {"period": None}, "memory = .*left out with a law of the model"),
        (3, {}, "controller = 3.*the name of a law, a function"),
        (None, {}, "controller = None.*a law, unless inputs are given"),
    ],
)
def test_arguments_without_a_meaning_are_refused(
    pendulum: runtime.Model, controller: Any, arguments: dict[str, Any], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        run(pendulum, controller, **arguments)
