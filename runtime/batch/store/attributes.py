# SPDX-License-Identifier: Apache-2.0
"""Attributes of a batch store, checked by a schema before use."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from mehvar.base.schema import SchemaError, parse, read

from ..plan import Campaign
from .arrays import STATUS, Array
from .records import FORMAT, digest

NAMES = ("mehvar_batch", "variables")
"""Attributes of every store: format, and names of variables."""
IDENTITY = ("model", "model_hash", "campaign", "success", "until", "require", "numerics", "law")
"""Attributes common to all blocks, whose hash every record contains. Only batches with a Python law have `law`, and
only those with requirements `require`.
"""
_JSON = ("campaign", "numerics", "drawn", "metrics", "nominal", "structure", "versions")
"""Attributes whose text is JSON."""
_KINDS = {"long_name": str, "units": str, "note": str, "flag_values": int, "flag_meanings": str, "ends": str}
"""Allowed types of array attributes; lists of a type are allowed too. Others can change the values that programs read,
such as `scale_factor` in xarray.
"""


@dataclass(frozen=True)
class Attributes:
    """Attributes of a store's group, without its format, and with the values of JSON texts.

    Attributes
    ----------
    variables : tuple of str
        Arrays with one row per run.
    model, model_hash, model_source, title, controller, scenario : str
        Name and hash of the model, the argument of `load`, the title of model and law, law and scenario.
    success, until, require : str
        Conditions, and JSON of requirements; empty for none.
    seed : int
        Seed of all random numbers.
    campaign : Any
        Fields of the `Campaign`.
    numerics, nominal, structure, versions : mapping
        All that affects rounding; nominal parameters; choices of the model; versions of libraries.
    drawn, metrics : tuple of str
        Names of drawn values and metrics.
    profile, flags, compiler : str
        Compilation settings of the first process.
    law : str
        The code of a law in Python.
    """

    variables: tuple[str, ...]
    title: str
    model: str
    model_hash: str
    model_source: str
    controller: str
    scenario: str
    success: str
    until: str
    seed: int
    campaign: Any
    numerics: Mapping[str, str]
    drawn: tuple[str, ...]
    metrics: tuple[str, ...]
    nominal: Mapping[str, float]
    structure: Mapping[str, str]
    versions: Mapping[str, str]
    profile: str
    flags: str
    compiler: str
    law: str = ""
    require: str = ""


@dataclass(frozen=True)
class _Require:
    """Requirements by name, with their confidence."""

    requirements: Mapping[str, str]
    confidence: float


def batch_hash(attributes: Mapping[str, Any], chunk: int) -> str:
    """Return a hash of everything common to all blocks, and of the runs per block."""
    identity = {name: attributes[name] for name in IDENTITY if name in attributes}
    return digest(json.dumps([identity, chunk], sort_keys=True).encode())


def check_group(attributes: Mapping[str, Any], arrays: Mapping[str, Array]) -> None:
    """Refuse attributes and arrays that no batch has.

    Raises
    ------
    SchemaError
        The message names the attribute.
    """
    if attributes.get(NAMES[0]) != FORMAT:
        version = attributes.get(NAMES[0])
        raise SchemaError(f" = {version!r}: must be {FORMAT}, the only version that this mehvar reads", NAMES[0])
    parsed = {name: _parsed(name, value) if name in _JSON else value for name, value in attributes.items()}
    about = read(Attributes, parsed, "any_age")
    try:
        read(Campaign, about.campaign)
    except SchemaError as error:
        raise error.within("campaign") from None
    if about.require:
        read(_Require, parse(about.require))
    if missing := {"generated", "options"} - about.numerics.keys():
        raise SchemaError(f": {min(missing)!r} is missing", "numerics")
    if not isinstance(parse(about.numerics["options"]), dict):
        raise SchemaError(": 'options' must be a table", "numerics")
    _check_arrays(about, arrays)


def _parsed(name: str, value: object) -> Any:
    if not isinstance(value, str):
        raise SchemaError(f" = {value!r}: must be a text", name)
    try:
        return parse(value)
    except SchemaError as error:
        raise error.within(name) from None


def _check_arrays(about: Attributes, arrays: Mapping[str, Array]) -> None:
    """Refuse unlisted arrays, arrays with other runs, and array attributes that mehvar does not write."""
    variables = {name: array for name, array in arrays.items() if array.of_runs}
    along = {dimension for array in variables.values() for dimension in array.dimensions[1:]}
    if variables.keys() != {STATUS, *about.variables} or arrays.keys() != {*about.variables, *along}:
        raise SchemaError(": must be the arrays of the store, except their coordinates", "variables")
    if len({(array.shape[0], array.chunk[0]) for array in variables.values()}) > 1:
        raise SchemaError(": must have the same runs and blocks", "variables")
    numbers = {name for name, array in variables.items() if len(array.shape) == 1 and array.dtype == "float64"}
    for name, array in arrays.items():
        place = f"{name}.attributes"
        if unknown := sorted(array.attributes.keys() - _KINDS.keys()):
            raise SchemaError(f": {unknown[0]!r} is not known", place)
        for key, value in array.attributes.items():
            kinds = {type(part) for part in (value if isinstance(value, list) else [value])}
            if not kinds <= {_KINDS[key]}:
                raise SchemaError(f" = {value!r}: must be of {_KINDS[key].__name__}", f"{place}.{key}")
        if name in numbers and not all(isinstance(array.attributes.get(key), str) for key in ("units", "long_name")):
            raise SchemaError(": must have units and long_name, both texts", place)
