# SPDX-License-Identifier: Apache-2.0
"""Attributes of a batch store, checked by a schema before use."""

import json
from collections.abc import Collection, Mapping
from dataclasses import dataclass, fields
from typing import Any

from mehvar.base.schema import SchemaError, parse, read

from .records import FORMAT, digest

NAMES = ("mehvar_batch", "variables")
"""Attributes of every store: format, and names of variables."""
IDENTITY = ("model", "model_hash", "campaign", "success", "until", "require", "numerics", "law")
"""Attributes common to all blocks, whose hash every record contains. Only batches with a Python law have `law`, and
only those with requirements `require`.
"""


@dataclass(frozen=True)
class Attributes:
    """Attributes of a store's group, without its format.

    Attributes
    ----------
    variables : tuple of str
        Arrays with one row per run.
    model, model_hash, model_source, title, controller, scenario : str
        Name and hash of the model, the argument of `load`, the title of model and law, law and scenario.
    success, until : str
        Conditions, empty for none.
    seed : int
        Seed of all random numbers.
    campaign, numerics, drawn, metrics, nominal, structure, versions : str
        JSON of `Texts`.
    profile, flags, compiler : str
        Compilation settings of the first process.
    law : str
        The code of a law in Python.
    require : str
        JSON of `RequireText`, empty for none.
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
    campaign: str
    numerics: str
    drawn: str
    metrics: str
    nominal: str
    structure: str
    versions: str
    profile: str
    flags: str
    compiler: str
    law: str = ""
    require: str = ""


@dataclass(frozen=True)
class CampaignText:
    """A `Campaign` as text, without its options."""

    controller: str
    n: int
    scenario: str | None
    seed: int
    vary: Mapping[str, str]
    parameters: Mapping[str, float]
    initial: Mapping[str, float]
    sampling: str
    save_every: float | None


@dataclass(frozen=True)
class RequireText:
    """Requirements by name, with their confidence."""

    requirements: Mapping[str, str]
    confidence: float


@dataclass(frozen=True)
class Texts:
    """Attributes that contain JSON."""

    campaign: CampaignText
    numerics: Mapping[str, str]
    drawn: tuple[str, ...]
    metrics: tuple[str, ...]
    nominal: Mapping[str, float]
    structure: Mapping[str, str]
    versions: Mapping[str, str]


_KINDS = {"long_name": str, "units": str, "note": str, "flag_values": int, "flag_meanings": str, "ends": str}
"""Allowed types of array attributes; lists of a type are allowed too."""
_OWN = ("t_stop", "error", "t_stiff")
"""Numbers of a run that are neither drawn values nor metrics."""


def batch_hash(identity: Mapping[str, Any], chunk: int) -> str:
    """Return a hash of everything common to all blocks, and of the runs per block."""
    return digest(json.dumps([identity, chunk], sort_keys=True).encode())


def check_attributes(attributes: Mapping[str, Any]) -> None:
    """Refuse attributes that no batch has or that contradict its campaign.

    Raises
    ------
    SchemaError
        The message names the attribute.
    """
    if attributes.get("mehvar_batch") != FORMAT:
        raise SchemaError(
            f" = {attributes.get('mehvar_batch')!r}: must be {FORMAT}, the only version that this mehvar reads",
            NAMES[0],
        )
    about = read(Attributes, attributes, "any_age")
    texts = _texts(about)
    campaign, options = texts.campaign, parse(about.campaign)["options"]
    profile = options.get("profile", "portable")
    for name, value, meaning in (
        ("controller", campaign.controller, "its campaign"),
        ("scenario", campaign.scenario or about.scenario, "its campaign"),
        ("seed", campaign.seed, "its campaign"),
        ("profile", profile, "its campaign"),
        ("profile", texts.numerics.get("profile"), "its numerics"),
    ):
        if getattr(about, name) != value:
            raise SchemaError(f" = {getattr(about, name)!r}: must be {value!r}, which {meaning} says", name)
    if about.require:
        read(RequireText, parse(about.require))
    if missing := {"generated", "options"} - texts.numerics.keys():
        raise SchemaError(f": {min(missing)!r} is missing", "numerics")
    if not _are_options(parse(texts.numerics["options"])):
        raise SchemaError(": 'options' must be a table", "numerics")
    drawn = {name.strip() for names in campaign.vary for name in names.split(",")}
    if {name.removeprefix("initial_") for name in texts.drawn} != {name.removeprefix("initial_") for name in drawn}:
        raise SchemaError(f" = {about.drawn!r}: must be the names that its campaign varies", "drawn")


def check_batch(attributes: Mapping[str, Any], about: Mapping[str, Any]) -> None:
    """Refuse attributes of a batch other than the record's.

    Raises
    ------
    SchemaError
        If the batches differ.
    """
    identity = {name: attributes[name] for name in IDENTITY if name in attributes}
    if batch_hash(identity, about["chunk"]) != about["batch"]:
        raise SchemaError(": do not match its records, which are of another batch", "its attributes")


def check_variables(attributes: Mapping[str, Any], numbers: Collection[str], own: Mapping[str, Any]) -> None:
    """Refuse variables that contradict the attributes, and array attributes that mehvar does not write.

    Unknown attributes can change the values that other programs read, such as `scale_factor` in xarray.

    Parameters
    ----------
    attributes : mapping
        Attributes of the group.
    numbers : collection of str
        Variables with one number per run.
    own : mapping of str to mapping
        Attributes of each variable and coordinate.

    Raises
    ------
    SchemaError
        The message names the attribute.
    """
    drawn, metrics = parse(attributes["drawn"]), parse(attributes["metrics"])
    if sorted([*drawn, *metrics]) != sorted(set(numbers) - set(_OWN)):
        raise SchemaError(
            f" = {attributes['metrics']!r}: must be the store's numbers of a run, except the drawn values", "metrics"
        )
    for name, values in own.items():
        place = f"{name}.attributes"
        if unknown := sorted(values.keys() - _KINDS.keys()):
            raise SchemaError(f": {unknown[0]!r} is not known", place)
        for key, value in values.items():
            kinds = {type(part) for part in (value if isinstance(value, list) else [value])}
            if not kinds <= {_KINDS[key]}:
                raise SchemaError(f" = {value!r}: must be of {_KINDS[key].__name__}", f"{place}.{key}")
        if name in numbers and not (isinstance(values.get("units"), str) and isinstance(values.get("long_name"), str)):
            raise SchemaError(": must have units and long_name, both texts", place)


def _texts(about: Attributes) -> Texts:
    values: dict[str, Any] = {}
    for field in fields(Texts):
        try:
            values[field.name] = parse(getattr(about, field.name))
        except SchemaError as error:
            raise SchemaError(error.problem, field.name) from error
    campaign = values["campaign"]
    if not isinstance(campaign, dict) or not _are_options(campaign.get("options")):
        raise SchemaError(": must be a table with options by name", "campaign")
    return read(Texts, {**values, "campaign": {name: v for name, v in campaign.items() if name != "options"}})


def _are_options(values: object) -> bool:
    return isinstance(values, dict) and all(isinstance(value, str | int | float | None) for value in values.values())
