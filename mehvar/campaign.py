# SPDX-License-Identifier: Apache-2.0
"""A batch as a TOML file: the same names as on the command line and in Python."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from mehvar.errors import InputError, shown
from mehvar.runtime.batch.plan import Campaign
from mehvar.runtime.batch.sampling import DESIGNS, Design
from mehvar.runtime.model.catalogue import find_folder, find_model
from mehvar.runtime.run.options import either, split_settings
from mehvar.runtime.units import distribution, read_value, setting_units
from mehvar.schema import parse_toml


class _Table(BaseModel):
    # Strict, so that a truth value is no number; the rows of the options say what a number may be.
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class Save(_Table):
    """Which series are stored: one sample every `every` seconds."""

    every: Any


class CampaignFile(_Table):
    """The contents of a campaign file, with the command line over it; `Campaign` and its options say what is allowed.

    `set` takes parameters, options and choices as `--set` does, `vary` distributions as `--vary` does, `initial`
    states; a text may be a number with a unit, those of `t_end` and `save` too.
    """

    model: str
    controller: str
    n: int
    scenario: str | None = None
    seed: int = Campaign.seed
    sampling: Design = Campaign.sampling
    t_end: Any = None
    success: str | None = None
    until: str | None = None
    out: Annotated[Path | None, Field(strict=False)] = None
    save: Save | None = None
    set: dict[str, Any] = {}
    initial: dict[str, Any] = {}
    vary: dict[str, str] = {}

    def under(self, flags: Mapping[str, Any]) -> CampaignFile:
        """Return the campaign with the fields of a command line over it; `set` and `vary` name by name."""
        tables = {name: {**getattr(self, name), **flags.get(name, {})} for name in ("set", "vary")}
        return self.model_copy(update={**flags, **tables})

    def campaign(self, origin: str) -> Campaign:
        """Return what decides the numbers of the batch.

        Raises
        ------
        InputError
            For a model, a scenario or an option that is none; the message says where it came from.
        """
        manifest = find_model(self.model)
        if self.t_end is not None and "t_end" in self.set:
            raise InputError(f"t_end is given twice (from {origin}): by itself and in set")
        units = setting_units(manifest)
        values = {name: _number(value, units, name, origin) for name, value in self.set.items()}
        settings = values if self.t_end is None else {**values, "t_end": _number(self.t_end, units, "t_end", origin)}
        units |= {"save": units["t_end"]} | {q.name: q.unit for q in manifest.states}
        parameters, options = split_settings(settings, manifest.choices, "batch", origin)
        return Campaign(
            controller=self.controller,
            n=self.n,
            scenario=manifest.scenario(self.scenario).name,
            seed=self.seed,
            vary={names: distribution(names, text, units, origin) for names, text in self.vary.items()},
            parameters=parameters,
            initial={name: _number(value, units, name, origin) for name, value in self.initial.items()},
            sampling=self.sampling,
            options=options,
            save_every=None if self.save is None else _number(self.save.every, units, "save", origin),
        )


def _number(value: Any, units: Mapping[str, str], name: str, origin: str) -> Any:
    """Return the number that a text with a unit is; any other value as it is."""
    return read_value(value, units.get(name), name, origin) if isinstance(value, str) else value


def read_campaign(path: Path) -> CampaignFile:
    """Read a campaign file, which means the same wherever one stands.

    `model` is a name that comes with mehvar or is of the project that the file is in, or else a folder; a relative one
    counts from the file's folder, and so does `out`. What is called like a known model is reached as "./NAME".

    Raises
    ------
    InputError
        For a file that cannot be read, is not TOML, or says something that is not understood; the message names the
        field.
    """
    try:
        file = CampaignFile.model_validate(parse_toml(path.read_text(encoding="utf-8-sig")))
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror or error}") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{path} is not TOML: {error}") from error
    except ValidationError as error:
        raise InputError("\n".join(f"{path}: {_sentence(dict(item))}" for item in error.errors())) from error
    out = None if file.out is None else path.parent / file.out
    return file.model_copy(update={"model": str(find_folder(file.model, path.parent)), "out": out})


_KINDS = {
    **dict.fromkeys(("dict_type", "model_type", "model_attributes_type"), "a table, as in [name]"),
    **dict.fromkeys(("int_type", "int_parsing", "int_from_float"), "a whole number"),
    **dict.fromkeys(("float_type", "float_parsing"), "a number"),
    **dict.fromkeys(("string_type", "path_type"), "a text"),
    "literal_error": either(DESIGNS),
}
"""What pydantic's kinds of errors mean to who writes TOML; the only literal is the design of the points."""


def _sentence(item: dict[str, object]) -> str:
    """Say field, value and what is allowed from one of pydantic's errors."""
    place = item["loc"]
    field = ".".join(map(str, place)) if isinstance(place, tuple) else ""
    if item["type"] == "missing":
        return f"{field} is missing"
    if item["type"] == "extra_forbidden":
        return f"{field} is not known; known: {', '.join(CampaignFile.model_fields)}"
    allowed = _KINDS.get(str(item["type"]))
    return f"{field} = {shown(item['input'])}: " + (f"must be {allowed}" if allowed else str(item["msg"]))
