# SPDX-License-Identifier: Apache-2.0
"""What a model is to whoever runs it: the schema of manifest.json.

Generation writes these classes and the runtime reads them, by `mehvar.schema`; neither knows the other's room. A field
that manifests have not always had carries a default, which is what an older one means when revisions are compared; a
run refuses the older one.
"""

import json
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

from mehvar.errors import InputError, unknown_name
from mehvar.schema import Lower, SchemaError, Upper, json_key, plain, read

FILE = "manifest.json"
SCHEMA = 1
METRIC_KINDS = ("settling", "settling_about_end", "max", "min", "max_abs", "rms", "travel", "sign_changes", "final")
"""What a metric may be, numbered as in the C text of batches."""


@dataclass(frozen=True)
class Quantity:
    """A named number with a unit and one line of description."""

    name: str
    unit: str
    description: str


@dataclass(frozen=True)
class Parameter:
    """A quantity with a default (a number, or a formula in other parameters) and bounds."""

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

    def allows(self, value: float) -> bool:
        """Return whether a value is within the bounds; never true for NaN."""
        above = value > self.lower if self.lower_open else value >= self.lower
        below = value < self.upper if self.upper_open else value <= self.upper
        return above and below

    @property
    def interval(self) -> str:
        """The bounds as in "[0, inf)"."""
        left = "(" if self.lower_open or math.isinf(self.lower) else "["
        right = ")" if self.upper_open or math.isinf(self.upper) else "]"
        return f"{left}{self.lower:.12g}, {self.upper:.12g}{right}"

    @property
    def allowed(self) -> str:
        """The bounds with their unit as in "[0, inf) kg"."""
        return self.interval if self.unit == "1" else f"{self.interval} {self.unit}"


@dataclass(frozen=True)
class Choice:
    """An option of a run with named values, such as a simpler plant; the first value is the default."""

    name: str
    values: tuple[str, ...]
    description: str


@dataclass(frozen=True)
class Advice:
    """What a law says of parameters that it accepts but should not have; `shown` values go into the message."""

    message: str
    shown: int


@dataclass(frozen=True)
class Output(Quantity):
    """What a law reports along a run; a run in which it is above `at_most` is not as it should be."""

    at_most: Upper


@dataclass(frozen=True, kw_only=True)
class Controller:
    """A control law.

    Attributes
    ----------
    name, title : str
        Identifier and one line for people.
    memory : tuple of Quantity
        What a sampled law keeps from one sample to the next.
    period : str or None
        Plant parameter that is the sampling period; None for a law that is continuous in time.
    delay : str or None
        The law's own parameter that is the delay of the loop, in samples; None for a law that is not designed for one.
    bears_loss : bool
        Whether a sampled law keeps its memory finite when a measurement is not, and commands zero.
    parameters : tuple of Parameter
        The vector c.
    constraints, warnings
        What parameters must satisfy, in words, and what they should.
    outputs : tuple of Output
        What the law reports.
    """

    name: str
    title: str
    memory: tuple[Quantity, ...]
    period: str | None
    delay: str | None = None
    bears_loss: bool = False
    parameters: tuple[Parameter, ...]
    constraints: tuple[str, ...]
    outputs: tuple[Output, ...] = ()
    warnings: tuple[Advice, ...]


@dataclass(frozen=True)
class Scenario:
    """A run that the paper or we describe: values, duration and the numbers it is expected to show.

    Parameters
    ----------
    name, title : str
        Identifier and one line for people.
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
    values: Mapping[str, float] = field(metadata=json_key("set"))
    controllers: Mapping[str, Mapping[str, float]]
    expect: Mapping[str, Mapping[str, Upper]]


@dataclass(frozen=True)
class Metric:
    """A number that sums up a run.

    Parameters
    ----------
    name, kind, unit, description : str
        `kind` is one of `METRIC_KINDS`.
    of : tuple of str
        Variables of the result, or differences of two as in "roll - ym_roll".
    band : float
        Settling band or dead band, in the unit of the variables.
    since, until : float
        Part of the run that counts, s.
    """

    name: str
    kind: str
    of: tuple[str, ...]
    band: float = field(default=0.0, kw_only=True)
    since: float = field(default=0.0, kw_only=True)
    until: Upper = field(default=math.inf, kw_only=True)
    unit: str
    description: str


class Array(NamedTuple):
    """An argument or a result: its name and how many numbers it holds, None for a scalar."""

    name: str
    length: int | None

    @property
    def size(self) -> int:
        """How many numbers it holds."""
        return 1 if self.length is None else self.length

    @property
    def shape(self) -> tuple[int, ...]:
        """Its shape, empty for a scalar."""
        return () if self.length is None else (self.length,)


@dataclass(frozen=True)
class Function:
    """A generated function: arguments, results, operation count, and the C file that holds it."""

    name: str
    description: str
    arguments: tuple[Array, ...] = field(metadata=json_key("args"))
    results: tuple[Array, ...]
    operations: int
    file: str

    @cached_property
    def shapes(self) -> tuple[tuple[int, ...], ...]:
        """The shape of each result: a number, a vector, or a matrix of derivatives."""
        return tuple(result_shape(self.name, result, self.arguments) for result in self.results)


def result_shape(function: str, result: Array, arguments: Sequence[Array]) -> tuple[int, ...]:
    """Return the shape of a result: that of the array, or of a matrix with a column for each element of an argument.

    Parameters
    ----------
    function : str
        Its name, with the word `jac` in that of a derivative; the result J of `jac_ARG` is differentiated with respect
        to ARG.
    result : Array
        One called `J_ARG` is differentiated with respect to ARG.
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
        Identifier, one line for people, and the publication.
    structure : mapping of str to str
        The structural choices it was derived with.
    hash : str
        SHA-256 of what the functions compute and of the names and units of their vectors.
    states, inputs, references, outputs, coordinates, noise : tuple of Quantity
        x, u, r, y, the regular coordinates q, and the random numbers of a measurement.
    parameters, scenario_parameters : tuple of Parameter
        p and s.
    controllers, scenarios, metrics, choices, functions : mapping by name
        Laws, runs, what runs are judged by, options with named values, and the generated functions.
    constraints, limits, reference_constant
        What parameters and runs must satisfy, in words; whether r does not depend on time.
    versions : mapping of str to str
        Of the libraries that derived it.
    inputs_sha256, files_sha256 : mapping of str to str
        SHA-256 of every source file it depends on and of every other file of its folder.
    shapes_sha256 : mapping of str to str
        SHA-256 of each table with every number taken as zero; empty where new numbers need a new derivation.
    folder, text
        Where it was read from, and the text of the file.
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
    constraints: tuple[str, ...]
    reference_constant: bool
    choices: Mapping[str, Choice]
    noise: tuple[Quantity, ...]
    scenarios: Mapping[str, Scenario]
    metrics: Mapping[str, Metric]
    functions: Mapping[str, Function]
    versions: Mapping[str, str]
    inputs_sha256: Mapping[str, str] = field(default_factory=dict)
    files_sha256: Mapping[str, str] = field(default_factory=dict)
    shapes_sha256: Mapping[str, str] = field(default_factory=dict)
    folder: Path = field(default=Path(), metadata=json_key(None))
    text: str = field(default="", metadata=json_key(None))

    def controller(self, name: str) -> Controller:
        """Return a control law by name, or raise InputError with the names that there are."""
        if name not in self.controllers:
            raise unknown_name(f"controller of {self.model}", name, self.controllers)
        return self.controllers[name]

    def scenario(self, name: str | None) -> Scenario:
        """Return a scenario by name (the first one for None), or raise InputError with the names that there are."""
        if name is None and self.scenarios:
            return next(iter(self.scenarios.values()))
        if name is None or name not in self.scenarios:
            raise unknown_name(f"scenario of {self.model}", name, self.scenarios)
        return self.scenarios[name]


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
        If the file is missing, is not JSON, has another schema, or a field is missing, not known or of a wrong kind.
    """
    path = Path(folder) / FILE
    try:
        text = path.read_text(encoding="utf-8")
        data = json.loads(text)
    except OSError as error:
        reason = error.strerror or str(error)
        raise InputError(f"{folder} is not a generated model folder: {path}: {reason}") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{path} is not UTF-8 text: {error}") from error
    except json.JSONDecodeError as error:
        raise InputError(f"{path} is not JSON: {error}") from error
    schema = data.get("schema") if isinstance(data, dict) else None
    if schema != SCHEMA:
        raise InputError(f"{path}: schema = {schema!r}: must be {SCHEMA}; generate the model again")
    try:
        return read(Manifest, data, any_age, folder=Path(folder), text=text)
    except SchemaError as error:
        raise InputError(f"{path}: {error}; generate the model again") from error


def manifest_text(manifest: Manifest) -> str:
    """Return the text of a manifest.json."""
    return json.dumps(plain(Manifest, manifest), indent=1, ensure_ascii=False) + "\n"
