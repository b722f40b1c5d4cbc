# SPDX-License-Identifier: Apache-2.0
"""A model whose parts do not fit together is refused."""

import dataclasses
import functools
import inspect
import math
import re
import subprocess
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import sympy as sp
from hypothesis import assume, given
from hypothesis import strategies as st

import mehvar
from mehvar import runtime
from mehvar.base.names import ARGUMENTS
from mehvar.base.units import dimension, unit_text
from mehvar.codegen.functions.graphs import generate_functions
from mehvar.codegen.functions.lower import LoweringError
from mehvar.codegen.functions.verify import check_counterparts
from mehvar.codegen.workspace import installed_tree
from mehvar.models.check import check, formulas, no_branching
from mehvar.models.check.dimensions import Dimensions, MisfitError
from mehvar.models.derivation import free_symbols
from mehvar.models.system import (
    EMPTY,
    TIME,
    Controller,
    Group,
    Interval,
    Metric,
    ModelError,
    Parameter,
    Quantity,
    Scenario,
    System,
)
from mehvar.models.tables import read_scenarios
from mehvar.runtime.run.options import OPTIONS
from tests.derived import system
from tests.models.edits import cart, put, turner

triangle = functools.partial(system, "triangle")


def with_parameter(group: Group, name: str, default: float | str = 1.0) -> Group:
    extra = Parameter(
        name, "1", "extra", default=default, bounds=Interval(0, 2, False, False), source="assumption: test"
    )
    return Group(group.name, (*group.quantities, extra))


def test_the_triangle_is_in_order():
    check(triangle())


def test_a_first_model_is_a_name_states_and_their_rates():
    """All else has a default, and numbers stand for expressions."""
    x = Group("x", (Quantity("q", "m", "place"), Quantity("v", "m/s", "speed")))
    p = Group("p", (Parameter("a", "m/s^2", "acceleration", default=2, bounds="[0, 9)"),))
    fall = System(name="fall", states=x, parameters=p, rhs=(x.v, p.a))
    check(fall)
    assert fall.initial == (0, 0)
    assert not p.quantities[0].positive
    run = mehvar.simulate(mehvar.build(fall), None, inputs={}, initial={"v": 1.0}, t_end=3.0)
    assert float(run["q"][-1]) == pytest.approx(3.0 + 9.0)
    still = System(name="still", states=x, rhs=(x.v, 0), initial=(0, 0.0))
    check(still)
    assert all(isinstance(entry, sp.Expr) for entry in (*still.rhs, *still.initial))
    with pytest.raises(ModelError, match=r"test_check.py:\d+: parameter 'b': bounds '0..1' must be an interval"):
        Parameter("b", "1", "share", bounds="0..1")


def test_an_unused_plant_parameter_is_refused():
    bad = dataclasses.replace(triangle(), parameters=with_parameter(triangle().parameters, "masss"))
    with pytest.raises(ModelError, match=r"parameter 'masss' .* is used by no right-hand side.*did you mean 'mass'"):
        check(bad)


def test_names_that_would_be_one_constant_in_c_are_refused():
    bad = dataclasses.replace(triangle(), parameters=with_parameter(triangle().parameters, "Mass"))
    with pytest.raises(ModelError, match=r"'mass' and 'Mass' of vector 'p' differ only in case"):
        check(bad)


def test_words_of_the_command_line_name_no_model_and_no_law():
    law = dataclasses.replace(triangle().controllers[0], name="none")
    with pytest.raises(ModelError, match="the law is called 'none', which stands for a run without a law: rename it"):
        check(dataclasses.replace(triangle(), controllers=(law,)))
    with pytest.raises(ModelError, match="the model is called 'work'"):
        check(dataclasses.replace(triangle(), name="work"))


def test_an_unused_law_parameter_is_refused():
    law = triangle().controllers[0]
    bad = dataclasses.replace(law, parameters=with_parameter(law.parameters, "gain"))
    with pytest.raises(ModelError, match=r"parameter 'gain' \(law 'sliding'\)"):
        check(dataclasses.replace(triangle(), controllers=(bad,)))


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        ({"period": "Tss"}, r"period = 'Tss' of law 'sliding' is not a parameter of group 'p'"),
        ({"delay": "k_ph"}, r"delay = 'k_ph' of law 'sliding' is not a parameter of group 'c'.*k_phi"),
    ],
)
def test_a_period_or_a_delay_that_is_no_parameter_is_refused(edit, message):
    law = dataclasses.replace(triangle().controllers[0], **edit)
    with pytest.raises(ModelError, match=message):
        check(dataclasses.replace(triangle(), controllers=(law,)))


def test_a_formula_in_an_unknown_name_is_refused():
    group = with_parameter(triangle().controllers[0].parameters, "twice", "2*k_ph")
    with pytest.raises(ModelError, match=r"uses 'k_ph', which is not a parameter of this group.*k_phi"):
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
        check(dataclasses.replace(triangle(), scenarios=(scenario,)))


def test_a_metric_of_an_unknown_variable_is_refused():
    metric = Metric("top", "max", ("rhoo",), "1", "")
    with pytest.raises(ModelError, match="variable 'rhoo' is not known"):
        check(dataclasses.replace(triangle(), metrics=(metric,), scenarios=()))


def test_a_reference_stands_in_a_metric_and_is_recorded():
    x = Group("x", (Quantity("a", "m", "place"), Quantity("v", "m/s", "speed")))
    r, s = Group("r", (Quantity("goal", "m", "goal"),)), Group("s", (Parameter("far", "m", "goal", default=3.0),))
    metric = Metric("worst", "max_abs", ("a - goal",), "m", "largest error")
    system = System(
        name="goal", states=x, references=r, scenario_parameters=s, reference=(s.far,), rhs=(x.v, 0),
        metrics=(metric,), scenarios=(Scenario("s", "", 1.0, 0.1),),
    )  # fmt: skip
    run = mehvar.simulate(mehvar.build(system), None, inputs={}, initial={"v": -0.5})
    np.testing.assert_array_equal(run["goal"], 3.0)
    assert float(run["worst"]) == float(abs(run["a"] - 3.0).max()) == 3.5


def test_a_function_that_makes_a_system_branches_on_no_symbol():
    x, p = Group("x", (Quantity("a", "1", "a"),)), Group("p", (Parameter("k", "1/s", "rate", default=1.0),))

    def wrong() -> System:
        return System(name="a", states=x, parameters=p, rhs=(-min(p.k, 1) * x.a,))

    with pytest.raises(ModelError, match=r"test_check.py:\d+: a Python branch .* sympy.Min"):
        mehvar.build(wrong)
    with pytest.raises(TypeError, match="truth value of Relational") as caught:
        wrong()
    assert ["sympy.Min" in note for note in caught.value.__notes__] == [True]


FRESH = """
import mehvar
from mehvar.models.quantities import Group, Quantity
from mehvar.models.system import System

x = Group("x", (Quantity("a", "1", "a"),))


def wrong():
    return System(name="a", states=x, rhs=(min(x.a, 1),))


mehvar.build(wrong)
"""


def test_the_first_symbol_of_a_process_may_be_in_the_branch(tmp_path):
    """SymPy's method is replaced at the first symbol, and must not hide the line of the model."""
    (tmp_path / "fresh.py").write_text(FRESH, encoding="utf-8")
    process = subprocess.run([sys.executable, "fresh.py"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert "ModelError: fresh.py:10: a Python branch asks for the truth of" in process.stderr


def test_branches_on_symbols_are_refused():
    x = sp.Symbol("x", real=True)
    with no_branching():
        with pytest.raises(ModelError, match="Python branch asks for the truth of"):
            bool(x + 1)
        with pytest.raises(ModelError, match="equality with"):
            _ = x == 0
        with pytest.raises(ModelError, match="equality with"):
            _ = x**2 != x
        with pytest.raises(ModelError, match=r"asks for the truth of .*sympy.Min"):
            min(x, sp.Symbol("limit", real=True))
        assert x == sp.Symbol("x", real=True)
        assert sp.integrate(sp.sin(x) ** 2, (x, 0, sp.pi)) is not None
    assert bool(x + 1)
    assert (x == 0) is False
    with pytest.raises(TypeError):
        bool(x > 0)


MASS = sp.Symbol("mass", positive=True)
MATRIX = sp.Matrix([[sp.Symbol("x", real=True), 0], [MASS * sp.cos(sp.Symbol("x", real=True)), MASS]])


def test_where_a_matrix_has_entries_may_be_asked():
    with no_branching():
        assert [(i, j) for i in range(2) for j in range(2) if MATRIX[i, j] != 0] == [(0, 0), (1, 0), (1, 1)]
        assert [k for k in range(4) if MATRIX[k] == 0] == [1]
        assert (
            MATRIX[
                0,
                1,
            ]
            == 0
        )
        assert MASS != 0


@pytest.mark.parametrize(
    "question",
    [
        lambda: MATRIX[0, 0] == 1,
        lambda: next(iter(MATRIX)) == 0,
        lambda: MATRIX[0, 0] + 1 == 0,
        lambda: any(entry != 0 for entry in MATRIX[:1]),
        lambda: MATRIX[0, 0] == MATRIX[1, 0],
    ],
)
def test_a_value_may_not_be_asked_of_a_matrix_either(question):
    with no_branching(), pytest.raises(ModelError, match=r"test_check.py:\d+: a Python branch asks for equality"):
        question()


def test_symbols_of_expressions_with_one_hash_are_looked_up():
    """Python's hash of -1 is that of -2, and a cache then compares both expressions."""
    x = sp.Symbol("x")
    assert hash(1 / x) == hash(x**-2)
    with no_branching():
        assert free_symbols([1 / x, x**-2], {}) == {x}


CART, TURNER = cart(), turner()
LAW = {law.name: k for k, law in enumerate(CART.controllers)}


def edited(system: System, path: tuple[str | int, ...], change: Callable[[Any], Any]) -> System:
    value: Any = system
    for part in path:
        value = value[part] if isinstance(part, int) else getattr(value, part)
    return put(system, path, change(value))


def settling(band: float) -> Metric:
    return Metric("settled", "settling", ("place",), band=band, unit="s", description="")


EXTRA, STATE = Quantity("extra", "m", ""), CART.states.quantities[0]
REFUSED = [
    ("rhs", CART, ("rhs",), lambda v: (*v, sp.S.Zero), r"rhs has 3 entries for 2 states \(place, speed\)"),
    ("rhs", CART, ("rhs",), lambda v: v[:1], r"rhs has 1 entries for 2 states"),
    ("output", CART, ("output",), lambda v: (*v, *v), r"output has 2 entries for 1 outputs \(E\)"),
    ("initial", CART, ("initial",), lambda v: v[:1], r"initial has 1 entries for 2 states"),
    ("reference", CART, ("reference",), lambda v: (), r"reference has 0 entries for 1 references"),
    ("variant", CART, ("variants", 0, "rhs"), lambda v: v[:1], r"rhs of variant 'none' has 1 entries"),
    ("command", CART, ("controllers", 0, "command"), lambda v: (*v, *v), r"command of law 'sum-law' has 2 entries"),
    ("start", CART, ("controllers", 0, "start"), lambda v: v[:1], r"start of law 'sum-law' has 1 entries for 2 memory"),
    ("update", CART, ("controllers", 0, "update"), lambda v: v[:1], r"update of law 'sum-law' has 1 entries"),
    ("measured", CART, ("sensor", "measured"), lambda v: v[:1], r"measured of the sensor has 1 entries for 2 states"),
    ("applied", CART, ("actuator", "applied"), lambda v: (), r"applied of the actuator has 0 entries for 1 inputs"),
    ("applied", CART, ("controllers", 0, "applied", "quantities"), lambda v: (*v, EXTRA),
     r"applied of law .* 2 entries"),
    ("projection", CART, ("projection",), lambda v: (STATE.symbol,), r"projection has 1 entries for 2 states"),
    ("to_input", TURNER, ("coordinates", "to_input"), lambda v: v[:1], r"to_input of the coordinates has 1 entries"),
    ("residual", CART, ("residual",), lambda v: (*v, *v), r"residual has 2 entries for 1 rates"),
    ("state and parameter", CART, ("parameters", "quantities", 0, "name"), lambda v: "speed",
     r"parameter 'speed' has the name of state 'speed'"),
    ("definition and state", CART, ("steps", 1, "symbol"), lambda v: STATE.symbol,
     r"edits.py:\d+: definition 'place' at .*edits.py:\d+ has the name of state 'place'"),
    ("memory and state", CART, ("controllers", 0, "memory", "quantities", 0, "name"), lambda v: "speed",
     r"memory of law 'sum-law' 'speed' has the name of state"),
    ("time", CART, ("states", "quantities", 0, "name"), lambda v: "t", r"state 't' has the name of time"),
    ("law's parameter and definition", CART, ("controllers", LAW["late"], "parameters", "quantities", 0, "name"),
     lambda v: "spring", r"parameter of law 'late' 'spring' has the name of definition 'spring' at"),
    ("memory of a continuous law", CART, ("controllers", LAW["smooth"], "memory"), lambda v: Group("z", (EXTRA,)),
     r"start of law 'smooth' has 0 entries for 1 memory \(extra\)"),
    ("delay of a continuous law", CART, ("controllers", LAW["late"], "period"), lambda v: "",
     r"delay of law 'late' would be ignored"),
    ("update without memory", CART, ("controllers", LAW["late"], "update"), lambda v: (sp.S.Zero,),
     r"update of law 'late' would be ignored: the law is without memory"),
    ("shown of a limit", CART, ("limits", 0, "shown"), lambda v: (STATE.symbol,), r"shown would be ignored"),
    ("message", CART, ("limits", 0, "message"), lambda v: "{speedy}", r"limits '\{speedy\}' cannot be filled in"),
    ("actuator beside a chart", TURNER, ("actuator",), lambda v: CART.actuator, r"cannot be combined with a regular"),
    ("a rate in another unit", CART, ("rhs", 0), lambda v: STATE.symbol,
     r"rhs, row 1 of 2 \(place\): place has the unit m: must be m/s"),
    ("a sum of units", CART, ("rhs", 0), lambda v: v + STATE.symbol,
     r"place \[m\] and speed \[m/s\] have different units"),
    ("a sine of a length", CART, ("rhs", 0), lambda v: v * sp.sin(STATE.symbol),
     r"sin needs a number without unit, but place has the unit m"),
    ("a stated unit", CART, ("steps", 0, "unit"), lambda v: "J",
     r"definition 'spring' at .*edits.py:\d+: .* has the unit kg m/s\^2, and declares J"),
    ("no unit", CART, ("states", "quantities", 0, "unit"), lambda v: "furlong", r"unit 'furlong' has 'furlong', which"),
    ("a state in degrees", CART, ("states", "quantities", 0, "unit"), lambda v: "deg",
     r"\(place\): unit = 'deg': must be in rad; only a parameter that sympy.rad"),
    ("an output in degrees", CART, ("outputs", "quantities", 0, "unit"), lambda v: "deg/s", r"must be in rad"),
    ("a metric in degrees", CART, ("metrics", 0, "unit"), lambda v: "deg m", r"'deg m': must be in rad"),
    ("period in metres", CART, ("parameters", "quantities", 4, "unit"), lambda v: "m",
     r"period = 'Ts' .* must be s"),
    ("period of zero", CART, ("parameters", "quantities", 4, "bounds"), lambda v: Interval(0.0, 1.0, False, False),
     r"period = 'Ts' of law 'sum-law' has the bounds \[0, 1\]: all values must be above zero"),
    ("a stranger", CART, ("rhs", 0), lambda v: v + sp.Symbol("speeed"),
     r"rhs, row 1 of 2 \(place\): 'speeed' belongs to no group of the system \(did you mean 'speed'\?\)"),
    ("a symbol made again", CART, ("rhs", 0), lambda v: sp.Symbol("speed"), r"other assumptions: take the symbol from"),
    ("a law's gain in a limit", CART, ("limits", 0, "margin"), lambda v: sp.Symbol("gain", real=True),
     r"margin 1 of limits, row 1 of 1: 'gain' is a parameter of law 'sum-law', which it does not receive"),
    ("time at the start", CART, ("initial", 0), lambda v: v * TIME.symbol, r"'t' is time, which it does not receive"),
    ("not a number", CART, ("rhs", 0), lambda v: sp.nan, r"has the constant nan: numbers must be real and finite"),
    ("infinity", CART, ("initial", 0), lambda v: sp.oo, r"initial, row 1 of 2 \(place\) has the constant oo"),
    ("a text", CART, ("rhs", 0), lambda v: "speed", r"rhs\[0\] = 'speed' is a str: must be a SymPy expr"),
    ("a list", CART, ("rhs",), list, r"rhs = \[.*\] is a list: must be a tuple"),
    ("a local name of C", CART, ("functions", 0, "name"), lambda v: "t_abcde",
     r"function 't_abcde': the name 't_abcde'"),
    ("a default that is not allowed", CART, ("parameters", "quantities", 0, "default"), lambda v: np.nan,
     r"parameter 'mass': default = nan is outside its bounds"),
    ("a formula that nothing computes", CART, ("parameters", "quantities", 0, "default"), lambda v: "2*k",
     r"default = '2\*k' must be a number: only laws"),
    ("a choice without variant", CART, ("variants",), lambda v: (), r"'variants' has no entry for \('none',\)"),
    ("a variable of a result", CART, ("outputs", "quantities", 0, "name"), lambda v: "u_force",
     r"output 'u_force' has the name of variable of input 'u_force'"),
    ("a negative band", CART, ("metrics",), lambda v: (settling(-1.0),), r"band = -1: must be above zero"),
    ("no band", CART, ("metrics",), lambda v: (settling(0.0),), r"band = 0: must be above zero"),
    ("a band that is not read", CART, ("metrics",), lambda v: (dataclasses.replace(v[0], band=1.0),),
     r"metric 'furthest' of cart: band = 1 would be ignored: max_abs uses none"),
    ("a window of no time", CART, ("metrics",), lambda v: (dataclasses.replace(v[0], since=2.0, until=2.0),),
     r"since = 2 and until = 2: must be 0 <= since < until"),
    ("a metric of nothing", CART, ("metrics", 0, "of"), lambda v: (), r"of = \[\]: must be one or more"),
    ("a final value of two", CART, ("metrics",), lambda v: (Metric("m", "final", ("place", "speed"), unit="m",
     description=""),), r"of = \['place', 'speed'\]: must be one, for final"),
    ("a difference of one", CART, ("metrics", 0, "of"), lambda v: ("place - place",),
     r"must be a variable or the difference of two"),
    ("a rate of turning in hertz", TURNER, ("metrics",), lambda v: (Metric("m", "max", ("u_round",), unit="Hz",
     description=""),), r"unit = 'Hz': must be rad/s, for max of 'u_round'"),
    ("a speed in radians", TURNER, ("metrics",), lambda v: (Metric("m", "max", ("u_out",), unit="rad m/s",
     description=""),), r"unit = 'rad m/s': must be m/s"),
    ("a metric with a blank", CART, ("metrics", 0, "name"), lambda v: "far off", r"metric 'far off': must be letters"),
    ("a scenario with a blank", CART, ("scenarios", 0, "name"), lambda v: "a/b", r"scenario 'a/b' of cart: the name"),
    ("the end of a comment", CART, ("title",), lambda v: "a cart */", r"title is 'a cart \*/': must be one line"),
    ("a backslash", CART, ("states", "quantities", 0, "description"), lambda v: r"\x is read",
     r"description of state 'place' is .*without .* backslashes"),
    ("two lines", CART, ("title",), lambda v: "a\ncart", r"title is 'a\\ncart': must be one line"),
    ("a difference of three", CART, ("metrics", 0, "of"), lambda v: ("place - place - place",),
     r"must be a variable or the difference of two"),
    ("a metric of two units", CART, ("metrics", 0, "of"), lambda v: ("place", "speed"),
     r"variables with the units m and m/s cannot be combined"),
    ("a metric in another unit", CART, ("metrics", 0, "unit"), lambda v: "s", r"unit = 's': must be m, for max_abs"),
    ("a settling time in metres", CART, ("metrics",), lambda v: (dataclasses.replace(settling(1.0), unit="m"),),
     r"unit = 'm': must be s, for settling"),
    ("a metric in no unit", CART, ("metrics", 0, "unit"), lambda v: "furlong", r"metric 'furthest' .*'furlong', which"),
    ("a formula of itself", CART, ("controllers", 0, "parameters", "quantities", 0, "default"), lambda v: "2*gain",
     r"law 'sum-law': the defaults of gain are circular formulas"),
    ("formulas of each other", CART, ("controllers", 0, "parameters", "quantities"),
     lambda v: (dataclasses.replace(v[0], default="leak"), dataclasses.replace(v[1], default="gain")),
     r"the defaults of gain, leak are circular formulas"),
    ("a limit that never holds", CART, ("limits", 0, "margin"), lambda v: sp.S.NegativeOne,
     r"margin 1 of limits, row 1 of 1: -1 does not depend on any symbol"),
    ("a constraint that always holds", CART, ("constraints", 0, "margin"), lambda v: sp.S.One,
     r"does not depend on any symbol"),
    ("noise that nothing reads", CART, ("sensor", "measured", 0), lambda v: CART.states.place + CART.parameters.sigma,
     r"noise 'hiss' would be ignored"),
    ("a command that does not act", CART, ("actuator", "applied", 0), lambda v: CART.parameters.top,
     r"commanded input 'asked' would be ignored"),
    ("a reference that nothing reads", CART, ("references", "quantities"), lambda v: (*v, EXTRA),
     r"reference has 1 entries for 2 references"),
    ("an applied input that nothing reads", CART, ("controllers", 0, "update", 1), lambda v: sp.S.Zero,
     r"applied of law 'sum-law' would be ignored"),
    *((f"a parameter called {name}", CART, ("parameters", "quantities", 0, "name"), lambda v, name=name: name,
       rf"parameter '{name}' has the name of an argument of a run") for name in ("hold", "seed", "step", "controller")),
    ("a choice called method", CART, ("choices", 0, "name"), lambda v: "method",
     r"choice 'method' has the name of an argument of a run"),
    ("a law's parameter called origin", CART, ("controllers", LAW["late"], "parameters", "quantities", 0, "name"),
     lambda v: "origin", r"parameter 'origin' of law 'late' has the name of an argument of a run"),
]  # fmt: skip


@pytest.mark.parametrize(
    ("system", "path", "change", "message"), [row[1:] for row in REFUSED], ids=[r[0] for r in REFUSED]
)
def test_an_edit_is_refused_with_file_line_and_name(system, path, change, message):
    with pytest.raises(ModelError, match=message) as refusal:
        check(edited(system, path, change))
    assert re.match(r"\S+\.py:\d+: ", str(refusal.value))


def test_no_argument_of_a_run_is_forgotten():
    signatures = [inspect.signature(f).parameters for f in (mehvar.simulate, mehvar.batch, runtime.simulate)]
    assert {*OPTIONS, *(name for names in signatures for name in names)} - {"options", "settings"} == ARGUMENTS


def test_a_law_need_not_read_what_was_applied():
    """Its function receives it all the same, as that of every law with memory."""
    law = dataclasses.replace(CART.controllers[0], applied=EMPTY, update=(CART.inputs.force / CART.parameters.k,) * 2)
    system = dataclasses.replace(CART, controllers=(dataclasses.replace(law, update=(law.update[0], sp.S.Zero)),))
    check(system)
    function = next(f for f in generate_functions(system) if f.name == "sum_law")
    assert function.arguments == (("x", 2), ("r", 1), ("v", 1), ("z", 2), ("p", 6), ("c", 2))


@pytest.mark.parametrize("place", ["definition", "rhs"])
def test_a_function_without_counterpart_is_placed(place):
    path = ("steps", 1, "expr") if place == "definition" else ("rhs", 1)
    system = edited(CART, path, lambda v: v * sp.gamma(STATE.symbol))
    with pytest.raises(LoweringError, match=rf"edits.py:\d+: {place}.*'gamma' has no CasADi counterpart"):
        check_counterparts(system)


def test_rational_exponents_are_units():
    unit = dimension("kg^(1/2) m/s")
    assert dimension("N^(1/2) m^(1/2)") == unit
    assert unit_text(unit) == "kg^(1/2) m/s"
    root = Quantity("root", "J^(1/2)", "root of the energy")
    system = dataclasses.replace(
        CART, outputs=Group("y", (*CART.outputs.quantities, root)), output=(*CART.output, sp.sqrt(CART.output[0]))
    )
    check(system)
    with pytest.raises(ModelError, match=r"row 2 of 2 \(root\): .* has the unit kg\^\(1/2\) m/s: must be J"):
        check(edited(system, ("outputs", "quantities", 1, "unit"), lambda _: "J"))


def test_laws_are_checked_one_by_one():
    assert {c.name for c in triangle().controllers if isinstance(c, Controller)} == {"sliding", "path"}


@pytest.mark.parametrize(
    ("line", "old", "new", "message"),
    [
        ("T_theta = {", 'unit = "s"', 'unit = "m"', "metric 'T_theta' of triangle: unit = 'm': must be s"),
        ("T_theta = {", 'of = ["theta_error"]', 'of = ["thetaerror"]', "metric 'T_theta' of triangle: variable"),
        ("T_theta = {", "band = 0.01", "band = -0.01", "metric 'T_theta': band = -0.01: must be above zero"),
        (
            "[scenarios.paper]",
            "[scenarios.paper]",
            "[scenarios.paper]\nvalues.rho = 1.0",
            "scenario 'paper' of triangle",
        ),
    ],
)
def test_what_is_wrong_in_a_table_is_placed_where_it_stands(tmp_path, line, old, new, message):
    text = (installed_tree().root / "models" / "triangle" / "scenarios.toml").read_text()
    lines = text.splitlines()
    at = next(k for k, present in enumerate(lines) if present.startswith(line))
    lines[at] = lines[at].replace(old, new)
    (tmp_path / "scenarios.toml").write_text("\n".join(lines))

    def checked() -> None:
        scenarios, metrics = read_scenarios(tmp_path / "scenarios.toml")
        check(dataclasses.replace(triangle(), scenarios=scenarios, metrics=metrics), tmp_path)

    with pytest.raises(ModelError, match=re.escape(f"scenarios.toml:{at + 1}: {message}")):
        checked()


ANGLE, TURN = sp.Symbol("angle_deg", real=True), sp.Symbol("turn", real=True)


@pytest.mark.parametrize(
    "expr",
    [
        *(sp.sin(ANGLE), sp.exp(ANGLE), ANGLE + TURN, sp.Min(ANGLE, TURN), sp.atan2(ANGLE, TURN), TURN**ANGLE),
        *(sp.Piecewise((ANGLE, TURN > 0), (TURN, True)), sp.Abs(ANGLE) + TURN, sp.Mod(TURN, ANGLE)),
        *(sp.pi * ANGLE + TURN, ANGLE / 180 + TURN, sp.rad(3 * ANGLE) + TURN, sp.sin(ANGLE * 0.0174)),
    ],
    ids=str,
)
def test_degrees_are_taken_for_radians_nowhere(expr):
    with pytest.raises(MisfitError, match="deg"):
        Dimensions({ANGLE: "deg", TURN: "rad"})(expr)


@pytest.mark.parametrize(
    "expr",
    [
        *(
            sp.sin(sp.rad(ANGLE)),
            TURN - sp.rad(ANGLE),
            sp.rad(ANGLE) / 2 + TURN,
            sp.rad(ANGLE) ** 2 + TURN,
            ANGLE * (math.pi / 180) + TURN,
        ),
        *(ANGLE * TURN * sp.pi / 180 + TURN, math.radians(1) * ANGLE + TURN, sp.cos(sp.rad(ANGLE) * TURN)),
    ],
    ids=str,
)
def test_degrees_times_their_radians_are_radians(expr):
    assert not Dimensions({ANGLE: "deg", TURN: "rad"})(expr)


@given(st.floats(-1e3, 1e3).filter(bool))
def test_no_other_factor_turns_degrees_into_radians(factor):
    assume(abs(math.remainder(math.log2(abs(math.degrees(factor))), 1)) > 1e-12)  # a half and a double do too
    assert Dimensions({ANGLE: "deg"})(factor * ANGLE) == {"deg": 1}
