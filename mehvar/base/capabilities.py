# SPDX-License-Identifier: Apache-2.0
"""Table of capabilities: for each feature of a model, the operations that refuse it and the features that exclude it.

Every refusal of a feature by name follows this table, and `python -m docs.site.capabilities` writes its page. An
operation accepts each feature that no row refuses.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from enum import Enum

from .errors import InputError
from .manifest import Controller, Manifest

Names = Iterable[str] | bool
"""Names of the parts of a model that have the feature. For a feature without named parts: True or False."""


class Operation(Enum):
    """Operation on a model, such as a batch or an export: its name in messages and in the page's table."""

    EXPLICIT = "an explicit method", "`dop853`, `dopri5`, `rk4`, `rock4`, `auto`"
    IMPLICIT = "a linearly implicit method", "`rodas5p`"
    STOCHASTIC = "a method for process noise", "`euler`, `platen`"
    CONTINUOUS = "a continuous loop", "a continuous loop"
    HELD = "a law that is sampled by hold", "`hold` of a continuous law"
    BOARD = "a board", "`board`"
    FMU = "a functional mock-up unit", "`export fmu`"
    PAGE = "a page", "`export web`"
    LINEARIZE = "a linear system x' = A x + B u", "`linearize`"
    IVP = "an initial value problem of SciPy", "`as_solve_ivp`"
    NLSYS = "a nonlinear system of python-control", "`to_nlsys`"


@dataclass(frozen=True, eq=False)
class Feature:
    """A row of the table.

    Attributes
    ----------
    name : str
        Name, as in "has process noise".
    fields : tuple of str
        Fields of `System` and `Controller` that declare it.
    names : callable
        Returns the names of the parts of a manifest, and of an optional law, that have the feature.
    refused : tuple of Place
        Operations that refuse it by name.
    limited : mapping of Place to str
        Operations that accept a part of it, with a description of that part.
    """

    name: str
    fields: tuple[str, ...]
    names: Callable[[Manifest, Controller | None], Names] = lambda _manifest, _law: False
    refused: tuple[Operation, ...] = ()
    limited: Mapping[Operation, str] = field(default_factory=dict)

    def listed(self, names: Names) -> str:
        """Return the name of the feature and of the parts that have it, or an empty text."""
        texts = ", ".join(names) if not isinstance(names, bool) else ""
        return f"{self.name} ({texts})" if texts else self.name if names is True else ""

    def refuse(self, manifest: Manifest, place: Operation, law: Controller | None = None) -> None:
        """Raise InputError if the model or its law has the feature and the operation refuses it."""
        if place in self.refused and (present := self.listed(self.names(manifest, law))):
            raise InputError(f"{manifest.model} has {present}, which {place.value[0]} cannot have")


_EXPORTS = (Operation.FMU, Operation.PAGE)
_LEFT_OUT = {Operation.BOARD: "not in the self-test"} | dict.fromkeys(
    (Operation.LINEARIZE, Operation.IVP, Operation.NLSYS), "left out"
)

MASS = Feature("a mass matrix", ("mass",))
ALGEBRAIC = Feature(
    "algebraic states",
    ("mass",),
    lambda manifest, _: manifest.algebraic,
    (
        Operation.EXPLICIT,
        Operation.STOCHASTIC,
        Operation.BOARD,
        *_EXPORTS,
        Operation.LINEARIZE,
        Operation.IVP,
        Operation.NLSYS,
    ),
)
DERIVED_RATES = Feature("rates and residual", ("rates", "residual"))
EVENTS = Feature(
    "events",
    ("events",),
    lambda manifest, _: (event.name for event in manifest.all_events),
    (Operation.PAGE,),
    _LEFT_OUT,
)
RESETS = Feature("events with resets", ("events",))
PROCESS_NOISE = Feature(
    "process noise",
    ("diffusion",),
    lambda manifest, _: (q.name for q in manifest.wiener),
    (Operation.EXPLICIT, Operation.IMPLICIT, *_EXPORTS),
    _LEFT_OUT,
)
RANDOM_STEPS = Feature(
    "random steps",
    ("random_step",),
    lambda manifest, _: [q.name for q in manifest.random_step] or ["jump"] * (manifest.jump > 0),
    (Operation.CONTINUOUS, *_EXPORTS),
    _LEFT_OUT,
)
DELAYS = Feature(
    "delayed inputs",
    ("delays",),
    lambda manifest, _: manifest.delays,
    (Operation.CONTINUOUS, *_EXPORTS),
    _LEFT_OUT,
)
CHART = Feature("a regular chart", ("coordinates",))
ACTUATOR = Feature("an actuator under a continuous law", ("actuator",))
MEASURED = Feature("measured quantities under a continuous law", ("sensor",))
CHOICES = Feature(
    "choices",
    ("choices", "variants"),
    limited=dict.fromkeys(
        (Operation.IMPLICIT, *_EXPORTS, Operation.LINEARIZE, Operation.IVP, Operation.NLSYS), "the default"
    ),
)
INTEGRATED = Feature(
    "a continuous law with states of its own",
    ("memory", "rates", "start"),
    lambda _, law: [law.name] if law and law.memory and law.period is None else False,
    (Operation.HELD, Operation.BOARD, Operation.FMU, Operation.NLSYS),
)
FEATURES = (
    MASS, ALGEBRAIC, DERIVED_RATES, EVENTS, RESETS, PROCESS_NOISE, RANDOM_STEPS, DELAYS, CHART, ACTUATOR, MEASURED,
    CHOICES, INTEGRATED,
)  # fmt: skip
"""Features that some operation refuses, or that exclude another feature. All operations accept all other features."""

EXCLUSIONS: tuple[tuple[Feature, Feature, str], ...] = (
    (CHART, MASS, "the rhs of the chart gives its rates"),
    (CHOICES, MASS, "a variant gives the rates"),
    (DERIVED_RATES, MASS, "with a mass matrix rhs does not give the rates; solve for the rates in rhs"),
    (PROCESS_NOISE, ALGEBRAIC, "the methods for process noise do not solve for them"),
    (INTEGRATED, ALGEBRAIC, "a continuous law of such a system must have no memory"),
    (EVENTS, PROCESS_NOISE, "a path with noise crosses a guard infinitely often"),
    (EVENTS, ALGEBRAIC, "algebraic states would have to jump at an event"),
    (EVENTS, INTEGRATED, "the law's states would have to be computed at the instant of each event"),
    (RESETS, CHART, "the integrator uses the chart, in which nothing jumps"),
    (PROCESS_NOISE, CHART, "the integrator uses the chart, which has no noise"),
    (ACTUATOR, CHART, "such a law commands the inputs of the chart, without the actuator"),
    (MEASURED, CHART, "such a law is a function of the chart, not of measurements"),
)
"""Groups of features with reasons. A system has at most one feature of each group."""


def refused_feature(manifest: Manifest, place: Operation, law: Controller | None = None) -> str:
    """Return the first feature of a model that an operation refuses, or an empty text."""
    present = (f.listed(f.names(manifest, law)) for f in FEATURES if place in f.refused)
    return next(filter(None, present), "")


def refuse(manifest: Manifest, place: Operation, law: Controller | None = None) -> None:
    """Raise InputError if a model has a feature that an operation refuses.

    Raises
    ------
    InputError
        With the model, the feature, the parts that have it, and the operation.
    """
    for feature in FEATURES:
        feature.refuse(manifest, place, law)
