# SPDX-License-Identifier: Apache-2.0
"""A model whose parts do not fit together is refused."""

import dataclasses

import pytest
import sympy as sp

from mehvar.models.check import check, formulas, no_branching
from mehvar.models.system import Controller, Group, Interval, Metric, ModelError, Parameter, Scenario
from mehvar.models.triangle import system

SYSTEM = system()


def with_parameter(group: Group, name: str, default: float | str = 1.0) -> Group:
    extra = Parameter(
        name, "1", "extra", default=default, bounds=Interval(0, 2, False, False), source="assumption: test"
    )
    return Group(group.name, (*group.quantities, extra))


def test_the_triangle_is_in_order():
    check(SYSTEM)


def test_an_unused_plant_parameter_is_refused():
    bad = dataclasses.replace(SYSTEM, parameters=with_parameter(SYSTEM.parameters, "masss"))
    with pytest.raises(ModelError, match=r"parameter 'masss' .* is used by no right-hand side.*did you mean 'mass'"):
        check(bad)


def test_names_that_would_be_one_constant_in_c_are_refused():
    bad = dataclasses.replace(SYSTEM, parameters=with_parameter(SYSTEM.parameters, "Mass"))
    with pytest.raises(ModelError, match=r"'mass' and 'Mass' of vector 'p' differ in capitals only"):
        check(bad)


def test_an_unused_law_parameter_is_refused():
    law = SYSTEM.controllers[0]
    bad = dataclasses.replace(law, parameters=with_parameter(law.parameters, "gain"))
    with pytest.raises(ModelError, match=r"parameter 'gain' \(law 'sliding'\)"):
        check(dataclasses.replace(SYSTEM, controllers=(bad,)))


@pytest.mark.parametrize("field", ["period", "delay"])
def test_a_period_or_delay_that_is_no_parameter_is_refused(field):
    bad = dataclasses.replace(SYSTEM.controllers[0], **{field: "k_ph"})
    with pytest.raises(ModelError, match=f"law 'sliding': {field} 'k_ph' is not known"):
        check(dataclasses.replace(SYSTEM, controllers=(bad,)))


def test_a_formula_in_an_unknown_name_is_refused():
    group = with_parameter(SYSTEM.controllers[0].parameters, "twice", "2*k_ph")
    with pytest.raises(ModelError, match=r"uses 'k_ph', which is no parameter of this group.*k_phi"):
        formulas(group)


@pytest.mark.parametrize(
    ("scenario", "message"),
    [
        (
            Scenario("s", "", 1, 0.1, {"l1_00": 0.2}, {}, {}),
            r"parameter 'l1_00' is not known \(did you mean 'l1_0'",
        ),
        (Scenario("s", "", 1, 0.1, {"l1_0": -0.2}, {}, {}), r"l1_0 = -0.2 is outside its bounds \(0, inf\)"),
        (Scenario("s", "", 1, 0.1, {}, {"slidng": {}}, {}), "controller 'slidng' is not known"),
        (Scenario("s", "", 1, 0.1, {}, {"path": {"k_phi": 0.0}}, {}), "k_phi = 0 is outside"),
        (Scenario("s", "", 1, 0.1, {}, {}, {"path": {"T_thet": 1.0}}), "metric 'T_thet' is not known"),
    ],
)
def test_a_scenario_that_does_not_fit_is_refused(scenario, message):
    with pytest.raises(ModelError, match=message):
        check(dataclasses.replace(SYSTEM, scenarios=(scenario,)))


def test_a_metric_of_an_unknown_variable_is_refused():
    metric = Metric("top", "max", ("rhoo",), "1", "")
    with pytest.raises(ModelError, match="variable 'rhoo' is not known"):
        check(dataclasses.replace(SYSTEM, metrics=(metric,), scenarios=()))


def test_branches_on_symbols_are_refused():
    x = sp.Symbol("x", real=True)
    with no_branching():
        with pytest.raises(ModelError, match="Python branch asks for the truth of"):
            bool(x + 1)
        with pytest.raises(ModelError, match="equality with"):
            _ = x == 0
        with pytest.raises(ModelError, match="equality with"):
            _ = x**2 != x
        with pytest.raises(TypeError):
            bool(x > 0)
        assert x == sp.Symbol("x", real=True)
        assert sp.integrate(sp.sin(x) ** 2, (x, 0, sp.pi)) is not None
    assert bool(x + 1)
    assert (x == 0) is False


def test_laws_are_checked_one_by_one():
    assert {c.name for c in SYSTEM.controllers if isinstance(c, Controller)} == {"sliding", "path"}
