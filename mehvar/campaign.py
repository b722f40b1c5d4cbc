# SPDX-License-Identifier: Apache-2.0
"""Campaign file: a batch as TOML, with the same names as on the command line and in Python."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from mehvar.base.errors import InputError
from mehvar.base.schema import read_data
from mehvar.runtime.batch.dispersions import in_units
from mehvar.runtime.batch.plan import Campaign
from mehvar.runtime.batch.sampling import Design
from mehvar.runtime.model.catalogue import find_folder, find_model
from mehvar.runtime.run.options import split_settings
from mehvar.runtime.units import read_value, setting_units


@dataclass(frozen=True)
class Save:
    """Settings of stored series: one sample every `every` seconds."""

    every: Any


@dataclass(frozen=True)
class CampaignFile:
    """Contents of a campaign file, overridden by the command line. `Campaign` defines the valid values.

    `set` has parameters, options and choices as in `--set`, `vary` distributions as in `--vary`, `initial` states,
    and `require` requirements by name. A text may be a number with a unit, also in `t_end` and `save`.
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
    confidence: Any = None
    out: Path | None = None
    save: Save | None = None
    set: Mapping[str, Any] = field(default_factory=dict)
    initial: Mapping[str, Any] = field(default_factory=dict)
    vary: Mapping[str, str] = field(default_factory=dict)
    require: Mapping[str, str] = field(default_factory=dict)

    def under(self, flags: Mapping[str, Any]) -> CampaignFile:
        """Return the campaign with values of the command line; `set` and `vary` are merged by name."""
        tables = {name: {**getattr(self, name), **flags.get(name, {})} for name in ("set", "vary")}
        return replace(self, **{**flags, **tables})

    def campaign(self, origin: str) -> Campaign:
        """Return the part of the campaign that determines the numbers of the batch.

        Raises
        ------
        InputError
            For an unknown model, scenario or option; the message has the origin of the value.
        """
        manifest = find_model(self.model)
        if self.t_end is not None and "t_end" in self.set:
            raise InputError(f"t_end is given twice (from {origin}): as t_end and in set")
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
            vary=in_units(self.vary, units, origin),
            parameters=parameters,
            initial={name: _number(value, units, name, origin) for name, value in self.initial.items()},
            sampling=self.sampling,
            options=options,
            save_every=None if self.save is None else _number(self.save.every, units, "save", origin),
        )


def _number(value: Any, units: Mapping[str, str], name: str, origin: str) -> Any:
    """Convert a text with a unit to a number; return other values unchanged."""
    return read_value(value, units.get(name), name, origin) if isinstance(value, str) else value


def read_campaign(path: Path) -> CampaignFile:
    """Read a campaign file. Relative paths in it refer to its own folder.

    `model` is a model of mehvar or of the file's project, or a folder. Relative folders, also in `out`, start at the
    file's folder. Write "./NAME" for a folder with the name of a known model.

    Raises
    ------
    InputError
        If the file cannot be read, is not TOML, or has an invalid field, which the message names.
    """
    file = read_data(path, CampaignFile)
    out = None if file.out is None else path.parent / file.out
    return replace(file, model=str(find_folder(file.model, path.parent)), out=out)
