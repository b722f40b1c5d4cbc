# SPDX-License-Identifier: Apache-2.0
"""What a generated folder says about its model: names, units, defaults, bounds, scenarios, functions."""

from __future__ import annotations

import importlib.util
import json
import math
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mehvar.errors import InputError, unknown_name

SCHEMA = 1
FILE = "manifest.json"


@dataclass(frozen=True)
class Quantity:
    """A named number with a unit and one line of description."""

    name: str
    unit: str
    description: str


@dataclass(frozen=True)
class Parameter(Quantity):
    """A quantity with a default (a number, or a formula in other parameters) and bounds."""

    default: float | None
    formula: str | None
    lower: float
    upper: float
    lower_open: bool
    upper_open: bool
    source: str

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
    """An option of a run with named values; the first is the default."""

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

    at_most: float


@dataclass(frozen=True)
class Controller:
    """A control law: parameters, memory, reports.

    `period` is the plant parameter that holds its sampling period, `delay` its own parameter that holds the samples
    between a command and its action; None for a law without. A law that `bears_loss` keeps its memory finite when a
    measurement is not.
    """

    name: str
    title: str
    memory: tuple[Quantity, ...]
    period: str | None
    parameters: tuple[Parameter, ...]
    constraints: tuple[str, ...]
    warnings: tuple[Advice, ...]
    outputs: tuple[Output, ...] = ()
    delay: str | None = None
    bears_loss: bool = False


@dataclass(frozen=True)
class Scenario:
    """A described run: duration and sampling step in seconds, values, values per law, expected metrics."""

    name: str
    title: str
    duration: float
    step: float
    values: Mapping[str, float]
    controllers: Mapping[str, Mapping[str, float]]
    expect: Mapping[str, Any]


@dataclass(frozen=True)
class Metric:
    """A number that sums up a run from `since` to `until`, s.

    `of` names variables of the result, or differences of two as in "roll - ym_roll"; `band` is in their unit.
    """

    name: str
    kind: str
    of: tuple[str, ...]
    band: float
    unit: str
    description: str
    since: float = 0.0
    until: float = math.inf


@dataclass(frozen=True)
class Array:
    """Name and trailing shape of an argument or a result; an empty shape is a scalar."""

    name: str
    shape: tuple[int, ...]

    @property
    def size(self) -> int:
        """How many numbers it holds."""
        return math.prod(self.shape)


@dataclass(frozen=True)
class Function:
    """A generated function: arguments, results, operation count, and the C file that holds it."""

    name: str
    arguments: tuple[Array, ...]
    results: tuple[Array, ...]
    operations: int
    file: str


@dataclass(frozen=True)
class Manifest:
    """Everything the runtime knows about a model, and the folder it was read from.

    Attributes
    ----------
    folder, model, title, structure, hash, versions, text
        Where it is, what it is called, what it was derived with, and the file itself.
    states, inputs, references, outputs, coordinates, parameters, scenario_parameters, noise : tuple of Quantity
        x, u, r, y, the regular coordinates q, p, s, and the random numbers of a measurement.
    controllers, scenarios, metrics, choices, functions : mapping by name
        Laws, runs, what runs are judged by, options with named values, and the generated functions.
    constraints, limits, reference_constant
        What parameters and runs must satisfy, in words; whether r depends on time.
    """

    folder: Path
    model: str
    title: str
    structure: Mapping[str, Any]
    hash: str
    states: tuple[Quantity, ...]
    inputs: tuple[Quantity, ...]
    references: tuple[Quantity, ...]
    outputs: tuple[Quantity, ...]
    coordinates: tuple[Quantity, ...]
    parameters: tuple[Parameter, ...]
    controllers: Mapping[str, Controller]
    scenario_parameters: tuple[Parameter, ...]
    constraints: tuple[str, ...]
    limits: tuple[str, ...]
    scenarios: Mapping[str, Scenario]
    metrics: Mapping[str, Metric]
    reference_constant: bool
    choices: Mapping[str, Choice]
    noise: tuple[Quantity, ...]
    functions: Mapping[str, Function]
    versions: Mapping[str, str]
    text: str

    def controller(self, name: str) -> Controller:
        """Return a control law by name, or raise InputError with the known ones."""
        if name not in self.controllers:
            raise unknown_name(f"controller of {self.model}", name, self.controllers)
        return self.controllers[name]

    def scenario(self, name: str | None) -> Scenario:
        """Return a scenario by name (the first one for None), or raise InputError with the known ones."""
        if name is None and self.scenarios:
            return next(iter(self.scenarios.values()))
        if name is None or name not in self.scenarios:
            raise unknown_name(f"scenario of {self.model}", name, self.scenarios)
        return self.scenarios[name]


def identifier(name: str) -> str:
    """Return the C and Python identifier of a name such as `lyapunov-v1`."""
    return re.sub(r"\W", "_", name)


def known_models() -> dict[str, Path]:
    """Return the folders of the models that come with the `generated` package, by name."""
    spec = importlib.util.find_spec("mehvar.generated")
    roots = list(spec.submodule_search_locations or []) if spec else []
    folders = [folder for root in roots if Path(root).is_dir() for folder in sorted(Path(root).iterdir())]
    return {folder.name: folder for folder in folders if (folder / FILE).is_file()}


def find_model(model: str | os.PathLike[str]) -> Manifest:
    """Read the manifest of a model.

    Parameters
    ----------
    model : str or path
        The name of a model that comes with the `generated` package, or a generated folder.

    Raises
    ------
    InputError
        If there is no such model, or its manifest cannot be read.
    """
    known = known_models()
    if isinstance(model, str) and model in known:
        return read_manifest(known[model])
    folder = Path(model)
    if folder.is_dir():
        return read_manifest(folder)
    raise unknown_name("model (neither a known name nor a generated folder)", os.fspath(model), known)


def read_manifest(folder: str | os.PathLike[str]) -> Manifest:
    """Read manifest.json of a generated folder.

    Parameters
    ----------
    folder : path
        Such as generated/triangle.

    Raises
    ------
    InputError
        If the file is missing, is not JSON, has another schema, or lacks something.
    """
    path = Path(folder) / FILE
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        reason = error.strerror or str(error)
        raise InputError(f"{folder} is not a generated model folder: {path}: {reason}") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{path} is not UTF-8 text: {error}") from error
    try:
        data = json.loads(text)
    except json.JSONDecodeError as error:
        raise InputError(f"{path} is not JSON: {error}") from error
    schema = data.get("schema") if isinstance(data, dict) else None
    if schema != SCHEMA:
        raise InputError(f"{path}: schema = {schema!r}: must be {SCHEMA}; generate the model again")
    try:
        return _manifest(Path(folder), data, text)
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        what = f"{type(error).__name__}: {error}"
        raise InputError(f"{path} is damaged ({what}); generate the model again") from error


def _manifest(folder: Path, data: Mapping[str, Any], text: str) -> Manifest:
    return Manifest(
        folder=folder,
        model=data["model"],
        title=data["title"],
        structure=data.get("structure", {}),
        hash=data["hash"],
        states=_quantities(data["states"]),
        inputs=_quantities(data["inputs"]),
        references=_quantities(data["references"]),
        outputs=_quantities(data["outputs"]),
        coordinates=_quantities(data.get("coordinates") or []),
        parameters=_parameters(data["parameters"]),
        controllers={name: _controller(name, entry) for name, entry in data["controllers"].items()},
        scenario_parameters=_parameters(data["scenario_parameters"]),
        constraints=tuple(data["constraints"]),
        limits=tuple(data["limits"]),
        scenarios={name: _scenario(name, entry) for name, entry in data["scenarios"].items()},
        metrics={name: _metric(name, entry) for name, entry in data["metrics"].items()},
        reference_constant=bool(data["reference_constant"]),
        choices={
            name: Choice(name, tuple(entry["values"]), entry["description"])
            for name, entry in data.get("choices", {}).items()
        },
        noise=_quantities(data.get("noise") or []),
        functions={name: _function(name, entry) for name, entry in data["functions"].items()},
        versions=data.get("versions", {}),
        text=text,
    )


def _quantities(entries: list[dict[str, Any]]) -> tuple[Quantity, ...]:
    return tuple(Quantity(e["name"], e["unit"], e["description"]) for e in entries)


def _parameters(entries: list[dict[str, Any]]) -> tuple[Parameter, ...]:
    return tuple(
        Parameter(
            name=e["name"],
            unit=e["unit"],
            description=e["description"],
            default=None if e["default"] is None else float(e["default"]),
            formula=e.get("formula"),
            lower=-math.inf if e["lower"] is None else float(e["lower"]),
            upper=math.inf if e["upper"] is None else float(e["upper"]),
            lower_open=bool(e["lower_open"]),
            upper_open=bool(e["upper_open"]),
            source=e["source"],
        )
        for e in entries
    )


def _controller(name: str, entry: Mapping[str, Any]) -> Controller:
    return Controller(
        name=name,
        title=entry["title"],
        memory=_quantities(entry.get("memory", [])),
        period=entry.get("period"),
        parameters=_parameters(entry["parameters"]),
        constraints=tuple(entry.get("constraints", [])),
        warnings=tuple(Advice(e["message"], int(e["shown"])) for e in entry.get("warnings", [])),
        outputs=tuple(
            Output(e["name"], e["unit"], e["description"], math.inf if e["at_most"] is None else float(e["at_most"]))
            for e in entry.get("outputs", [])
        ),
        delay=entry["delay"],
        bears_loss=bool(entry["bears_loss"]),
    )


def _scenario(name: str, entry: Mapping[str, Any]) -> Scenario:
    return Scenario(
        name=name,
        title=entry["title"],
        duration=float(entry["duration"]),
        step=float(entry["step"]),
        values={key: float(value) for key, value in entry.get("set", {}).items()},
        controllers={
            law: {key: float(value) for key, value in values.items()}
            for law, values in entry.get("controllers", {}).items()
        },
        expect=entry.get("expect", {}),
    )


def _metric(name: str, entry: Mapping[str, Any]) -> Metric:
    return Metric(
        name=name,
        kind=entry["kind"],
        of=tuple(entry["of"]),
        band=float(entry.get("band") or 0.0),
        since=float(entry.get("since") or 0.0),
        until=math.inf if entry.get("until") is None else float(entry["until"]),
        unit=entry["unit"],
        description=entry["description"],
    )


def _function(name: str, entry: Mapping[str, Any]) -> Function:
    sizes = dict(entry["args"])
    results = [_array(*pair) for pair in entry["results"]]
    if name in ("jac_x", "jac_u"):
        rows = int(sizes["x"])
        results = [Array(a.name, (rows, a.size // rows)) for a in results]
    return Function(
        name=name,
        arguments=tuple(_array(*pair) for pair in entry["args"]),
        results=tuple(results),
        operations=int(entry.get("operations", 0)),
        file=entry["file"],
    )


def _array(name: str, size: int | None) -> Array:
    return Array(name, () if size is None else (int(size),))
