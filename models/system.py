# SPDX-License-Identifier: Apache-2.0
"""Vocabulary for models: parts of a system, control laws, scenarios.

All classes here are small frozen dataclasses. A model builds one `System`, which is all that code generation reads.
Quantities and derivations have their own modules, and the runtime's schema defines classes that the runtime reads
unchanged. This module exports them all.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from itertools import chain

import sympy as sp

from mehvar.base.display import displayed_formulas, heading
from mehvar.base.intervals import Interval
from mehvar.base.manifest import Choice, Metric, Scenario

from .derivation import Definition, Derivation, Equation, Expr, free_symbols
from .events import Event, surfaces
from .geometry import Shape
from .quantities import (
    EMPTY,
    LARGEST,
    TIME,
    Group,
    Located,
    ModelError,
    Parameter,
    Quantity,
    scalar,
    whole_periods,
)

__all__ = [
    "EMPTY",
    "LARGEST",
    "TIME",
    "Actuator",
    "Choice",
    "Condition",
    "Controller",
    "Coordinates",
    "Definition",
    "Derivation",
    "Diffusion",
    "Equation",
    "Event",
    "Expr",
    "Function",
    "Group",
    "Interval",
    "Metric",
    "ModelError",
    "Output",
    "Parameter",
    "Quantity",
    "RandomStep",
    "Scenario",
    "Sensor",
    "Shape",
    "System",
    "Variant",
    "free_symbols",
    "scalar",
    "surfaces",
    "whole_periods",
]


def latex(expr: Expr, names: Mapping[sp.Symbol, str]) -> str:
    """Return an expression as LaTeX, with given names of its symbols."""
    text: str = sp.latex(expr, symbol_names=dict(names))
    return text


@dataclass(frozen=True)
class Function(Located):
    """Public function of a model, such as rod lengths from shape.

    Parameters
    ----------
    name : str
        Name in C and Python.
    arguments : tuple of Group
        A group of one quantity is a scalar argument.
    results : tuple of (Quantity, Expr)
        Its results, in order.
    vector : str
        Name of the vector that holds the results; if empty, they are a tuple of scalars.
    description : str
        A one-line description.
    """

    name: str
    arguments: tuple[Group, ...]
    results: tuple[tuple[Quantity, Expr], ...]
    description: str
    vector: str = ""

    def _repr_latex_(self) -> str:
        names = {q.symbol: q.latex for q in (*chain(*self.arguments), *(q for q, _ in self.results)) if q.latex}
        return displayed_formulas([f"{latex(q.symbol, names)} = {latex(expr, names)}" for q, expr in self.results])


@dataclass(frozen=True)
class Coordinates(Located):
    """Regular chart for the integration of continuous loops, without the singularities of the state's chart.

    Parameters
    ----------
    states, inputs : Group
        The regular coordinates q and their inputs n.
    rhs : tuple of Expr
        q' as a function of q, n and the plant's parameters.
    from_state, from_input : tuple of Expr
        q as a function of the state x; n as a function of x and the input u.
    to_state, to_input : tuple of Expr
        The state x as a function of q; the input u as a function of q and n.
    """

    states: Group
    inputs: Group
    rhs: tuple[Expr, ...]
    from_state: tuple[Expr, ...]
    from_input: tuple[Expr, ...]
    to_state: tuple[Expr, ...]
    to_input: tuple[Expr, ...]


@dataclass(frozen=True)
class Condition(Located):
    """Condition that a quantity stays positive.

    Parameters
    ----------
    margin : Expr
        Allowed while greater than zero.
    message : str
        Message on violation; `{name}` is replaced by the value of that parameter, `{0}`, `{1}` by the values shown.
    shown : tuple of Expr
        Further values for the message of a law's warning; other conditions have none.
    """

    margin: Expr
    message: str
    shown: tuple[Expr, ...] = ()


@dataclass(frozen=True)
class Output:
    """Quantity that a law reports in a run, computed from recorded samples.

    Parameters
    ----------
    quantity : Quantity
        Its name in a result.
    value : Expr
        A function of state, reference, p, c and the law's memory before the update.
    at_least, at_most : float
        Limits; the result reports time and size of violations.
    """

    quantity: Quantity
    value: Expr
    at_most: float = float("inf")
    at_least: float = -float("inf")


@dataclass(frozen=True)
class Controller(Located):
    """Control law as a symbolic function (measurement, reference) -> input.

    If the sensor declares its own quantities, commands and updates are functions of these instead of the state.

    Parameters
    ----------
    name, title : str
        Identifier, and a one-line description.
    parameters : Group
        The law's own parameters.
    command : tuple of Expr
        The commanded input as a function of state, reference, plant parameters and law parameters; with regular
        coordinates, the inputs that belong to them. A law may use its memory, a sampled one the applied input too.
    constraints, warnings : tuple of Condition
        Conditions on plant, law and scenario parameters: required before a run, and recommended.
    period : str
        Plant parameter that holds the sampling period; empty for a continuous law.
    delay : str
        For a law designed for a delay, its parameter with the samples between computing and applying a command. By
        default a run sets it to the delay of its loop.
    applied : Group
        Symbols of the input that was actually applied over the last sample, for a sampled law.
    every : str
        The law's own parameter that holds the number of samples between commands of a sampled law; its memory is
        updated at every sample. Empty for a law that commands at each sample.
    memory : Group
        Values that a sampled law keeps between samples; for a continuous law, its integrated states.
    start, update : tuple of Expr
        The memory before the first sample (a function of state, reference, p and c) and after each one.
    rates : tuple of Expr
        z' of a continuous law with memory, with the same arguments as its command.
    outputs : tuple of Output
        Quantities that the law reports in addition to its command.
    events : tuple of Event
        Switching surfaces of a continuous law, as a function of state, reference, plant parameters and law parameters.
    tolerates_loss : bool
        True if a sampled law accepts measurements that are not finite: it keeps its memory finite and commands zero.
    in_numbers : bool
        True if the dimensions of the law's expressions are not checked, as for an estimator whose covariance mixes
        units.
    """

    name: str
    title: str
    parameters: Group
    command: tuple[Expr, ...]
    constraints: tuple[Condition, ...] = ()
    warnings: tuple[Condition, ...] = ()
    period: str = ""
    delay: str = field(default="", kw_only=True)
    applied: Group = EMPTY
    every: str = field(default="", kw_only=True)
    memory: Group = EMPTY
    start: tuple[Expr, ...] = ()
    update: tuple[Expr, ...] = ()
    rates: tuple[Expr, ...] = field(default=(), kw_only=True)
    outputs: tuple[Output, ...] = ()
    events: tuple[Event, ...] = field(default=(), kw_only=True)
    tolerates_loss: bool = False
    in_numbers: bool = field(default=False, kw_only=True)

    def _repr_latex_(self) -> str:
        names = {q.symbol: q.latex for group in (self.parameters, self.memory) for q in group if q.latex}
        return displayed_formulas([rf"u_{{{i}}} = {latex(expr, names)}" for i, expr in enumerate(self.command, 1)])


@dataclass(frozen=True)
class Actuator(Located):
    """Map from commanded to acting inputs, such as limits, gimbals or wheels.

    Parameters
    ----------
    commanded : Group
        Symbols of the commanded input, one for each input.
    applied : tuple of Expr
        The input that acts, as a function of state, commanded input and p.
    """

    commanded: Group
    applied: tuple[Expr, ...]


@dataclass(frozen=True)
class Sensor(Located):
    """Measurements that a law receives in place of the state.

    Parameters
    ----------
    noise : Group
        Independent standard normal numbers, drawn anew at each sample; zero for a continuous law.
    measured : tuple of Expr
        The measurements, as a function of state, noise and p: a row for each state, or for each of `seen`.
    seen : Group
        Measured quantities that laws receive in place of the state. By default a sampled law receives measured
        states, and a continuous law the states themselves.
    """

    noise: Group
    measured: tuple[Expr, ...]
    seen: Group = EMPTY


@dataclass(frozen=True)
class Diffusion(Located):
    """Process noise: dx = f dt + G dW, in the sense of Ito.

    Parameters
    ----------
    wiener : Group
        Independent Wiener processes, in s^(1/2): their increments over a step h have the variance h.
    change : tuple of Expr
        G dW, a row for each state: linear in the symbols of `wiener`, which stand for the increments, with
        coefficients in state and p.
    """

    wiener: Group
    change: tuple[Expr, ...]


@dataclass(frozen=True)
class RandomStep(Located):
    """Random change of the state at each sample of a sampled law, except the first.

    Parameters
    ----------
    noise : Group
        Independent standard normal numbers, drawn anew at each sample.
    after : tuple of Expr
        The state after the change, as a function of the state before it, noise and p.
    """

    noise: Group
    after: tuple[Expr, ...]


@dataclass(frozen=True)
class Variant(Located):
    """Variant of a system for non-default choices.

    Parameters
    ----------
    values : tuple of str
        One value for each choice of the system, in order.
    rhs : tuple of Expr
        x' as a function of x, u, p.
    loops : mapping of str to tuple of Expr
        For a law by name, a closed loop that differs from `rhs` under that law.
    """

    values: tuple[str, ...]
    rhs: tuple[Expr, ...]
    loops: Mapping[str, tuple[Expr, ...]]


_DEFAULT = Scenario("default", "from the defaults", 100.0, 0.1)
"""Default scenario of a system that declares none, long enough for some rotations at typical rates."""


@dataclass(frozen=True, kw_only=True)
class System(Located):
    """Mechanical system with laws and scenarios; input of code generation.

    Only name, states and rates are required. Numbers may replace expressions.

    Parameters
    ----------
    name, title, source : str
        Identifier, a one-line description, and the publication.
    structure : mapping
        The structural choices this system was derived with.
    states, inputs, references, outputs : Group
        x, u, r and y.
    parameters, scenario_parameters : Group
        p and s.
    rhs : tuple of Expr
        x' as a function of x, u, p.
    output : tuple of Expr
        y as a function of x, u, r, p.
    steps : tuple
        The derivation, in order.
    limits : tuple of Condition
        Conditions along a run, as a function of x, u and p.
    initial : tuple of Expr
        x(0) as a function of p and s; zero when empty.
    reference : tuple of Expr
        r as a function of time, p and s.
    constraints : tuple of Condition
        Conditions on plant and scenario parameters.
    functions : tuple of Function
        Further public functions.
    controllers : tuple of Controller
        The control laws.
    scenarios, metrics : tuple of Scenario and of Metric
        Scenarios of runs (default: 100 s) and the numbers that summarise a run.
    coordinates : Coordinates, optional
        Regular chart for continuous loops.
    actuator : Actuator, optional
        Map from the commanded to the acting input; without one, the input acts as commanded.
    sensor : Sensor, optional
        Measurements of sampled laws, and of all laws if it has its own quantities; without one, the state.
    diffusion : Diffusion, optional
        Process noise; a run needs a method for it.
    random_step : RandomStep, optional
        Random change of the state at each sample.
    delays : mapping of str to str
        For inputs by name, the plant parameter that holds the samples between command and action.
    projection : tuple of Expr
        Applied to the integrated coordinates after each accepted step, such as the norm of a quaternion.
    choices, variants : tuple
        Options of a run with named values, and a variant for each combination other than the defaults.
    rates : mapping of str to sympy.Symbol
        For each state of the derived equations of motion, the symbol of its rate in `residual`.
    residual : tuple of Expr
        These equations, zero for the true rates, one per state in `rates`. Give it if `rhs` is a faster form;
        generation fails unless both agree.
    events : tuple of Event
        Actions where a guard crosses zero; simultaneous ones occur in this order.
    geometry : tuple of Shape
        Shapes in the picture and animation of the system.
    mass : sympy.Matrix, optional
        A row and a column for each state, a function of x and p: mass x' = `rhs`. A state whose column and row are zero
        is algebraic: its row of `rhs` is zero along a run, and determines it.
    parts : mapping
        The fields of each part of a `Spacecraft` as texts, for `mehvar diff`.
    """

    name: str
    title: str = ""
    source: str = ""
    structure: Mapping[str, str] = field(default_factory=dict)
    states: Group
    inputs: Group = field(default_factory=partial(Group, "u", ()))
    references: Group = field(default_factory=partial(Group, "r", ()))
    outputs: Group = field(default_factory=partial(Group, "y", ()))
    parameters: Group = field(default_factory=partial(Group, "p", ()))
    scenario_parameters: Group = field(default_factory=partial(Group, "s", ()))
    rhs: tuple[Expr, ...]
    output: tuple[Expr, ...] = ()
    steps: tuple[Definition | Equation, ...] = ()
    limits: tuple[Condition, ...] = ()
    initial: tuple[Expr, ...] = ()
    reference: tuple[Expr, ...] = ()
    constraints: tuple[Condition, ...] = ()
    functions: tuple[Function, ...] = ()
    controllers: tuple[Controller, ...] = ()
    scenarios: tuple[Scenario, ...] = ()
    metrics: tuple[Metric, ...] = ()
    coordinates: Coordinates | None = None
    actuator: Actuator | None = None
    sensor: Sensor | None = None
    diffusion: Diffusion | None = None
    random_step: RandomStep | None = None
    delays: Mapping[str, str] = field(default_factory=dict)
    projection: tuple[Expr, ...] = ()
    choices: tuple[Choice, ...] = ()
    variants: tuple[Variant, ...] = ()
    rates: Mapping[str, sp.Symbol] = field(default_factory=dict)
    residual: tuple[Expr, ...] = ()
    geometry: tuple[Shape, ...] = ()
    mass: sp.MatrixBase | None = None
    events: tuple[Event, ...] = ()
    parts: Mapping[str, Mapping[str, str]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.initial and isinstance(self.states, Group):
            object.__setattr__(self, "initial", (sp.S.Zero,) * len(self.states))
        if not self.scenarios:
            object.__setattr__(self, "scenarios", (_DEFAULT,))
        self._report_references()

    def _report_references(self) -> None:
        """Make references that a metric names outputs, as which a run records them; `check_kinds` checks kinds."""
        if not isinstance(self.references, Group) or not isinstance(self.metrics, tuple) or not len(self.references):
            return
        metrics = [m for m in self.metrics if isinstance(m, Metric)]
        variables = [str(of) for m in metrics if isinstance(m.of, tuple) for of in m.of]
        named = {name.strip() for of in variables for name in of.split(" - ")}
        named -= {q.name for group in (self.states, self.outputs) for q in group}
        if wanted := tuple(q for q in self.references if q.name in named):
            outputs = Group(self.outputs.name, (*self.outputs, *wanted))
            object.__setattr__(self, "outputs", outputs)
            object.__setattr__(self, "output", (*self.output, *(q.symbol for q in wanted)))

    def _repr_latex_(self) -> str:
        names = {step.symbol: step.latex for step in self.definitions_in_order}
        names |= {q.symbol: q.latex for group in self._groups for q in group if q.latex}
        sides = zip(self.states, self.rhs, strict=True)
        return displayed_formulas([rf"\dot{{{latex(q.symbol, names)}}} = {latex(rate, names)}" for q, rate in sides])

    def _repr_html_(self) -> str:
        tables = (group._repr_html_() for group in self._groups)
        return "".join((heading(f"{self.name}: {self.title}"), *tables, self._repr_latex_()))

    @property
    def _groups(self) -> tuple[Group, ...]:
        return (self.states, self.inputs, self.outputs, self.parameters)

    @property
    def seen(self) -> Group:
        """Quantities that laws receive: the states, or a sensor's measurements."""
        return self.sensor.seen if self.sensor and len(self.sensor.seen) else self.states

    @property
    def definitions(self) -> dict[sp.Symbol, Expr]:
        """All definitions of the derivation, by symbol."""
        return {step.symbol: step.expr for step in self.definitions_in_order}

    @property
    def definitions_in_order(self) -> tuple[Definition, ...]:
        """All definitions of the derivation, in order."""
        return tuple(step for step in self.steps if isinstance(step, Definition))
