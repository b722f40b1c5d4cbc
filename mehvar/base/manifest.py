# SPDX-License-Identifier: Apache-2.0
"""Schema of manifest.json: the description of a generated model.

Generation writes these classes and the runtime reads them, through `schema`; neither depends on the other. A field
that older manifests lack has a default with the older meaning, for comparisons of revisions. Runs refuse older
manifests.
"""

import hashlib
import math
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, NamedTuple, Self, get_args

from mehvar.base.display import heading, table
from mehvar.base.errors import InputError, unknown_name
from mehvar.base.intervals import Interval
from mehvar.base.names import identifier
from mehvar.base.schema import Lower, SchemaError, Upper, json_key, json_text, parse, plain, read

FILE = "manifest.json"
SCHEMA = 1
OPEN_LOOP = "none"
"""Name of the law in a run without one; no law can have it."""
WITHOUT_LAW = "mehvar simulate takes --input NAME=VALUE, Python also a law of your own or a batch with inputs={...}"
Part = Literal["", "variants", "prepared", "variants_prepared", "jac", "outputs_jac", "parameters_jac", "loops_jac"]
"""C file of a model, by purpose."""
PREPARED: Mapping[Part, Part] = {"": "prepared", "variants": "variants_prepared"}
"""Names of the two files for the split functions of a C file, by the purpose of the C file."""
METRIC_KINDS = (
    "settling", "settling_about_end", "max", "min", "max_abs", "rms", "travel", "sign_changes", "final", "events",
)  # fmt: skip
"""Kinds of metrics, numbered as in the C code of batches."""

OF_SECONDS = ("settling", "settling_about_end")
"""Kinds of metrics that measure a settling time."""

Direction = Literal["either", "rising", "falling"]
DIRECTIONS: tuple[Direction, ...] = get_args(Direction)
"""Directions in which a guard may cross zero to trigger its event."""

ENDS = ("", "run", "failure", "success")
"""Effects of an event on the run: no end, or an end that counts as regular, as failure or as success. See
native/step/schedule.h."""

ShapeKind = Literal["rod", "arrow", "ball", "box", "face"]
SHAPE_KINDS: Mapping[ShapeKind, tuple[int, float]] = {
    "rod": (2, math.inf), "arrow": (2, 2), "ball": (1, 1), "box": (4, 4), "face": (3, math.inf),
}  # fmt: skip
"""Kinds of shapes of a picture, with their smallest and largest number of points."""
SHAPE_COLORS = ("blue", "vermillion", "green", "purple", "orange", "sky", "black", "grey")
"""Colours of shapes. Each name has one value for light pages and one for dark pages."""


@dataclass(frozen=True)
class Quantity:
    """A named number with a unit and one line of description."""

    name: str
    unit: str
    description: str


@dataclass(frozen=True)
class Parameter:
    """A quantity with a default (a number, or a formula in other parameters) and bounds.

    `readers` are the functions that depend on it, directly or through the reference. For `initial` and a law's
    formulas, whose elements a user may override, they are elements such as "initial.rho".
    """

    name: str
    unit: str
    default: float | None
    formula: str | None
    lower: Lower
    upper: Upper
    lower_open: bool
    upper_open: bool
    source: str
    description: str
    readers: tuple[str, ...] = ()

    def allows(self, values: Any) -> Any:
        """Return True for values within the bounds; NaN never is. An array gives an array."""
        return Interval(self.lower, self.upper, self.lower_open, self.upper_open).allows(values)

    @property
    def interval(self) -> str:
        """The bounds as text, as in "[0, inf)"."""
        left = "(" if self.lower_open or math.isinf(self.lower) else "["
        right = ")" if self.upper_open or math.isinf(self.upper) else "]"
        return f"{left}{self.lower:.12g}, {self.upper:.12g}{right}"

    @property
    def allowed(self) -> str:
        """The bounds with their unit, as in "[0, inf) kg"."""
        return self.interval if self.unit == "1" else f"{self.interval} {self.unit}"


def parameter_table(title: str, parameters: Sequence[Parameter]) -> str:
    """Return parameters as a table in HTML."""
    columns = ("name", "unit", "default", "allowed", "meaning", "source")
    rows = [(q.name, q.unit, q.formula or f"{q.default:g}", q.interval, q.description, q.source) for q in parameters]
    return table(title, columns, rows)


@dataclass(frozen=True)
class Choice:
    """An option of a run with named values, such as a simpler plant.

    Parameters
    ----------
    name, description : str
        Name, and a one-line description.
    values : tuple of str
        Two or more; the first is the default.
    """

    name: str
    values: tuple[str, ...]
    description: str


@dataclass(frozen=True)
class Advice:
    """Warning about parameter values that a law accepts but does not recommend.

    The message contains the values `shown`.
    """

    message: str
    shown: int


@dataclass(frozen=True)
class Output(Quantity):
    """Quantity that a law reports along a run. Values above `at_most` or below `at_least` need attention."""

    at_most: Upper
    at_least: Lower = -math.inf


@dataclass(frozen=True)
class Event:
    """Zero crossing of a guard.

    `resets` is True if it changes states; `ends` is its effect on the run, one of `ENDS`.
    """

    name: str
    direction: Direction
    resets: bool
    ends: str
    title: str

    @property
    def numbers(self) -> tuple[int, int, int]:
        """Direction, resets and ends as the numbers of native/step/state.h."""
        return (0, 1, -1)[DIRECTIONS.index(self.direction)], int(self.resets), ENDS.index(self.ends)


@dataclass(frozen=True, kw_only=True)
class Controller:
    """A control law.

    Attributes
    ----------
    name, title : str
        Identifier, and a one-line description.
    memory : tuple of Quantity
        Values that a sampled law keeps between samples, or integrated states of a continuous law.
    period : str or None
        Plant parameter that is the sampling period; None for a law that is continuous in time.
    delay : str or None
        Parameter of the law with the delay of the loop in samples; None for a law without one.
    tolerates_loss : bool
        True if a sampled law commands zero and keeps its memory finite when a measurement is not finite.
    parameters : tuple of Parameter
        The vector c.
    constraints, warnings
        Required and recommended conditions on parameters, in words.
    outputs : tuple of Output
        Quantities that the law reports.
    events : tuple of Event
        Switching surfaces of a continuous law.
    """

    name: str
    title: str
    memory: tuple[Quantity, ...]
    period: str | None
    delay: str | None = None
    tolerates_loss: bool = False
    parameters: tuple[Parameter, ...]
    constraints: tuple[str, ...]
    outputs: tuple[Output, ...] = ()
    events: tuple[Event, ...] = ()
    warnings: tuple[Advice, ...]

    def _repr_html_(self) -> str:
        period = f", sampled with the period {self.period}" if self.period else ""
        return heading(f"law {self.name}: {self.title}{period}") + parameter_table("parameters c", self.parameters)


@dataclass(frozen=True)
class Scenario:
    """Predefined run: parameter values, duration, and the metrics expected for each law.

    Parameters
    ----------
    name, title : str
        Identifier, and a one-line description.
    duration, step : float
        Length of the run and sampling step of its result, s.
    values : mapping of str to float
        Plant and scenario parameters that differ from their defaults.
    controllers : mapping of str to mapping
        Law parameters that differ from their defaults, per law.
    expect : mapping of str to mapping
        Expected metrics per law.
    """

    name: str
    title: str
    duration: float
    step: float
    values: Mapping[str, float] = field(default_factory=dict, metadata=json_key("set"))
    controllers: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    expect: Mapping[str, Mapping[str, Upper]] = field(default_factory=dict)

    def _repr_html_(self) -> str:
        values = [(name, f"{value:g}", "") for name, value in self.values.items()]
        special = [
            (name, f"{value:g}", law) for law, group in self.controllers.items() for name, value in group.items()
        ]
        text = f"scenario {self.name}: {self.title}; {self.duration:g} s in steps of {self.step:g} s"
        return heading(text) + table("values that differ from the defaults", ("name", "value", "law"), values + special)


@dataclass(frozen=True)
class Metric:
    """A number that summarises a run.

    Parameters
    ----------
    name, kind, unit, description : str
        `kind` is "settling", "settling_about_end", "max", "min", "max_abs", "rms", "travel", "sign_changes", "final" or
        "events"; docs/reference/parameters-and-scenarios-toml.md defines them.
    of : tuple of str
        Variables of the result, or differences of two as in "roll - ym_roll".
    band : float
        Settling band or dead band, in the unit of the variables.
    since, until : float
        Time window of the metric, s.
    """

    name: str
    kind: str
    of: tuple[str, ...]
    band: float = field(default=0.0, kw_only=True)
    since: float = field(default=0.0, kw_only=True)
    until: Upper = field(default=math.inf, kw_only=True)
    unit: str
    description: str


@dataclass(frozen=True)
class Shape:
    """Part of a picture of the system. The function `geometry` returns the points of all shapes."""

    name: str
    kind: ShapeKind
    points: int
    color: str


class Array(NamedTuple):
    """Name and length of an argument or a result; the length of a scalar is None."""

    name: str
    length: int | None

    @property
    def size(self) -> int:
        """Number of elements."""
        return 1 if self.length is None else self.length

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the array; empty for a scalar."""
        return () if self.length is None else (self.length,)


Signature = tuple[Array, ...]
"""Arguments or results of a function."""


@dataclass(frozen=True)
class Function:
    """A generated function: arguments, results, and the C file that holds it.

    Attributes
    ----------
    operations : int
        Number of its operations.
    chain : int
        Number of operations in the longest chain in which each needs the result of the one before.
    """

    name: str
    description: str
    arguments: Signature = field(metadata=json_key("args"))
    results: Signature
    operations: int
    chain: int
    file: str

    @property
    def internal(self) -> bool:
        """True for one part of a split function: a run computes the first part only once."""
        return self.file.endswith("_prepared.c")

    @cached_property
    def shapes(self) -> tuple[tuple[int, ...], ...]:
        """The shape of each result: a number, a vector, or a matrix of derivatives."""
        return tuple(result_shape(self.name, result, self.arguments) for result in self.results)


def result_shape(function: str, result: Array, arguments: Sequence[Array]) -> tuple[int, ...]:
    """Return the shape of a result: an array, or a matrix with a column for each element of an argument.

    Parameters
    ----------
    function : str
        Its name. The name of a derivative contains `jac`; the result J of `jac_ARG` is differentiated with respect to
        ARG.
    result : Array
        The result; `J_ARG` is differentiated with respect to ARG.
    arguments : sequence of Array
        Of the function.
    """
    name = function.removeprefix("jac_") if result.name == "J" else result.name.removeprefix("J_")
    columns = next((a.size for a in arguments if a.name == name), 0)
    # a moment of inertia may be called J_x too
    if "jac" not in function.split("_") or result.length is None or name == result.name or not columns:
        return result.shape
    return (result.length // columns, columns)


@dataclass(frozen=True, kw_only=True)
class Manifest:
    """A generated model.

    Attributes
    ----------
    schema : int
        Version of the format.
    model, title, source : str
        Identifier, a one-line description, and the publication.
    structure : mapping of str to str
        The structural choices it was derived with.
    hash : str
        SHA-256 of the computations of the functions, and of the names and units of their vectors.
    states, inputs, references, outputs, coordinates, noise : tuple of Quantity
        x, u, r, y, the regular coordinates q, and the random numbers of a measurement.
    parameters, scenario_parameters : tuple of Parameter
        p and s.
    controllers, scenarios, metrics, choices, functions : mapping by name
        Laws, runs, criteria for runs, options with named values, and the generated functions.
    measured : tuple of Quantity
        Measurements that laws receive in place of the state; empty if they receive the state.
    wiener, random_step : tuple of Quantity
        The Wiener processes of process noise, and the random numbers of a random step.
    delays : mapping of str to str
        For inputs by name, the parameter with the delay in samples.
    geometry : tuple of Shape
        Shapes in a picture of the system.
    events : tuple of Event
        Events at zero crossings of guards.
    constraints, limits, reference_constant
        Conditions on parameters and on runs, in words; True if r does not depend on time.
    limits_of_state : bool
        True if limits do not depend on the input and continuous loops integrate the state itself.
    parts : mapping
        The fields of each part of a spacecraft as texts.
    versions : mapping of str to str
        Versions of the libraries that derived it.
    inputs_sha256, files_sha256 : mapping of str to str
        SHA-256 of every source file it depends on and of every other file of its folder.
    shapes_sha256 : mapping of str to str
        SHA-256 of each table with all numbers set to zero; empty if new numbers need a new derivation.
    digest : str
        SHA-256 of the file without this entry.
    folder, text
        Its folder, and the text of the file.
    """

    schema: int = SCHEMA
    model: str
    title: str
    source: str
    structure: Mapping[str, str]
    hash: str
    states: tuple[Quantity, ...]
    inputs: tuple[Quantity, ...]
    references: tuple[Quantity, ...]
    outputs: tuple[Quantity, ...]
    coordinates: tuple[Quantity, ...]
    parameters: tuple[Parameter, ...]
    scenario_parameters: tuple[Parameter, ...]
    controllers: Mapping[str, Controller]
    limits: tuple[str, ...]
    limits_of_state: bool = False
    constraints: tuple[str, ...]
    reference_constant: bool
    choices: Mapping[str, Choice]
    noise: tuple[Quantity, ...]
    measured: tuple[Quantity, ...] = ()
    wiener: tuple[Quantity, ...] = ()
    random_step: tuple[Quantity, ...] = ()
    delays: Mapping[str, str] = field(default_factory=dict)
    scenarios: Mapping[str, Scenario]
    metrics: Mapping[str, Metric]
    geometry: tuple[Shape, ...] = ()
    events: tuple[Event, ...] = ()
    functions: Mapping[str, Function]
    parts: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    versions: Mapping[str, str]
    inputs_sha256: Mapping[str, str] = field(default_factory=dict)
    files_sha256: Mapping[str, str] = field(default_factory=dict)
    shapes_sha256: Mapping[str, str] = field(default_factory=dict)
    digest: str = ""
    folder: Path = field(default=Path(), metadata=json_key(None))
    text: str = field(default="", metadata=json_key(None))

    @property
    def seen(self) -> tuple[Quantity, ...]:
        """Vector that laws receive: the state, or the measurements if the system has a sensor."""
        return self.measured or self.states

    @property
    def jump(self) -> int:
        """Zero or, if states change at samples, one and the number of random numbers of such a step."""
        return len(self.random_step) + 1 if "jump" in self.functions else 0

    def random(self, sampled: bool) -> bool:
        """Return True if runs depend on a seed."""
        return bool(self.wiener) or (sampled and bool(self.noise or self.random_step))

    def controller(self, name: str) -> Controller:
        """Return a control law by name, or raise InputError with the known names."""
        if not isinstance(name, str) or name not in self.controllers:
            note = WITHOUT_LAW if isinstance(name, str) and name == OPEN_LOOP else ""
            raise unknown_name(f"controller of {self.model}", name, self.controllers, note=note)
        return self.controllers[name]

    @property
    def all_events(self) -> tuple[Event, ...]:
        """The system's events, and the surfaces of its laws."""
        return (*self.events, *(event for law in self.controllers.values() for event in law.events))

    def scenario(self, name: str | None) -> Scenario:
        """Return a scenario by name (the first one for None), or raise InputError with the known names."""
        if name is None and self.scenarios:
            return next(iter(self.scenarios.values()))
        if not isinstance(name, str) or name not in self.scenarios:
            raise unknown_name(f"scenario of {self.model}", name, self.scenarios)
        return self.scenarios[name]

    @property
    def algebraic(self) -> bool:
        """True if there are algebraic states, whose rows of `rhs` are zero along a run."""
        return "mass_diagonal" in self.functions

    @property
    def projects_by_parameters(self) -> bool:
        """True if the projection of the states depends on parameters, such as lengths."""
        return "project" in self.functions and len(self.functions["project"].arguments) > 1

    def c_name(self, function: str) -> str:
        """Return the name of a function in the generated C."""
        return f"{identifier(self.model)}_{identifier(function)}"

    def module_of(self, function: Function) -> str:
        """Return the name of a function's Python file: as in C, except for derivatives of rates."""
        own = function.file == file_of(self.model, "jac")
        return file_of(self.model, "", "py") if own else function.file.removesuffix(".c") + ".py"

    @property
    def whole(self) -> Self:
        """Return the manifest without split functions, which Python and CasADi's C lack."""
        functions = {name: f for name, f in self.functions.items() if not f.internal}
        return replace(self, functions=functions)


def read_manifest(folder: str | os.PathLike[str], any_age: bool = False) -> Manifest:
    """Read manifest.json of a generated folder.

    Parameters
    ----------
    folder : path
        Such as generated/triangle.
    any_age : bool
        Accept a manifest with more or fewer fields, as another version wrote it.

    Raises
    ------
    InputError
        If the file is missing or is not JSON of this schema, or a field is missing, unknown or of a wrong type.
    """
    path = Path(folder) / FILE
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        reason = error.strerror or str(error)
        raise InputError(f"{folder} is not a generated model folder: {path}: {reason}") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{path} is not UTF-8 text: {error}") from error
    return parse_manifest(text, path, any_age)


def parse_manifest(text: str, path: Path, any_age: bool = False) -> Manifest:
    """Parse the text of a manifest; `path` is only used in messages. Raises as `read_manifest` does."""
    try:
        data = parse(text)
    except SchemaError as error:
        raise InputError(f"{path} {error}") from error
    schema = data.get("schema") if isinstance(data, dict) else None
    if schema != SCHEMA:
        raise InputError(f"{path}: schema = {schema!r}: must be {SCHEMA}; generate the model again")
    if ("digest" in data or not any_age) and (with_digest(text) != text or not _DIGEST.search(text)):
        raise InputError(
            f"{path} was changed after generation: its digest does not match. Change the sources and run mehvar "
            "generate, or restore the file"
        )
    try:
        manifest = replace(read(Manifest, data, "any_age" if any_age else "exact"), folder=path.parent, text=text)
        if not any_age:
            _check_functions(manifest)
        return manifest
    except SchemaError as error:
        raise InputError(f"{path}: {error}; generate the model again") from error


def file_of(model: str, part: Part, kind: Literal["c", "py"] = "c") -> str:
    """Return the name of a model's C file, or of the corresponding Python file."""
    return f"{model}_{part}.{kind}" if part else f"{model}.{kind}"


def files_on_first_use(model: str) -> frozenset[str]:
    """Return the names of rarely used files, which a generated folder omits and mehvar makes at first use.

    They are CasADi's own C; derivatives with respect to parameters; derivatives of laws and of closed loops; and in
    Python all derivatives except the rates' derivatives.
    """
    derivatives = [part for part in get_args(Part) if part.endswith("_jac")]
    return frozenset(
        {f"{model}_casadi.c", f"{model}_casadi.h"}
        | {file_of(model, part) for part in ("parameters_jac", "loops_jac")}
        | {file_of(model, part, "py") for part in derivatives}
    )


_PLANT = {
    "rhs": "x u p -> dx",
    "outputs": "x u r p -> y",
    "limits": "x u p -> margin",
    "initial": "p s -> x",
    "reference": "t p s -> r",
    "constraints": "p s -> margin",
    "to_coordinates": "x -> q",
    "from_coordinates": "q -> x",
    "project": "q -> q_next",
    "actuate": "x u_cmd p -> u",
    "measure": "x e p -> x_seen",
    "mass_diagonal": "p -> m",
    "diffuse": "x dw p -> x_step",
    "jump": "x e p -> x_after",
    "input_delays": "p -> d",
    "guards": "x u p -> g",
    "resets": "x u p event -> x_next",
    "geometry": "x u r p -> points",
    "jac_x": "x u p -> J",
    "jac_u": "x u p -> J",
}
"""Arguments and results of each function of a plant. A model has only the functions that its features need."""
_NEEDED = ("rhs", "outputs", "limits", "initial", "reference", "constraints")
"""Functions of every plant."""


def _law_signatures(manifest: Manifest, law: Controller) -> Iterator[tuple[str, str]]:
    """Yield the name of each function of a law, with its arguments and results."""
    name, x, continuous = identifier(law.name), "seen" if manifest.measured else "x", law.period is None
    command = f"{x} r z p c -> u dz" if continuous else f"{x} r v z p c -> u z_next"
    reports = manifest.functions.get(f"{name}_outputs")
    for end, present, signature in (
        ("", True, command if law.memory else f"{x} r p c -> u"),
        ("_start", law.memory, "x r p c -> z"),
        ("_constraints", law.constraints, "p c s -> margin"),
        ("_warnings", law.warnings, "p c s -> margin"),
        ("_outputs", law.outputs, "x r z p c -> w" if reports and reads_memory(reports) else "x r p c -> w"),
        ("_loop", continuous, "q r p c -> dq"),
        ("_observe", continuous, "q r p c -> x u u_cmd" if "actuate" in manifest.functions else "q r p c -> x u"),
        ("_guards", continuous and (manifest.events or law.events), "q r p c -> g"),
        ("_defaults", any(q.formula is not None for q in law.parameters), "c -> derived"),
    ):
        if present:
            yield f"{name}{end}", signature


def _check_functions(manifest: Manifest) -> None:
    """Refuse functions with other arguments or results, as another version of mehvar generates them.

    A run passes arguments by position. The digest protects everything else.
    """
    functions = {identifier(f.name): f for f in manifest.functions.values()}
    plant = _PLANT | ({"project": "q p -> q_next"} if manifest.projects_by_parameters else {})
    plant |= {"measure": "x e p -> seen"} if manifest.measured else {}
    expected = {name: signature for name, signature in plant.items() if name in (*_NEEDED, *functions)}
    for law in manifest.controllers.values():
        expected |= _law_signatures(manifest, law)
    for name, signature in expected.items():
        if name not in functions:
            raise SchemaError(f": {name!r} is missing", "functions")
        sides = (functions[name].arguments, functions[name].results)
        present = " -> ".join(" ".join(array.name for array in side) for side in sides)
        if present != signature:
            raise SchemaError(f" = {present!r}: must be {signature!r}", f"functions.{name}")


def reads_memory(outputs: Function) -> bool:
    """Return True if a report of the law depends on its memory."""
    return any(array.name == "z" for array in outputs.arguments)


def manifest_text(manifest: Manifest) -> str:
    """Return the text of a manifest.json with its digest."""
    return with_digest(json_text({**plain(Manifest, manifest), "digest": ""}))


def with_digest(text: str) -> str:
    """Insert the digest of the rest of a manifest.json into its text.

    The digest protects data that neither code nor header confirms: the order of a law's outputs, bounds of
    parameters, and units.
    """
    blank = _DIGEST.sub(_NO_DIGEST, text)
    return blank.replace(_NO_DIGEST, f'\n "digest": "{hashlib.sha256(blank.encode()).hexdigest()}"')


_DIGEST, _NO_DIGEST = re.compile(r'\n "digest": "[^"]*"'), '\n "digest": ""'
"""Patterns of the digest at the top level of the JSON; deeper levels have more indentation."""
