# SPDX-License-Identifier: Apache-2.0
"""A batch as a TOML file: the same names as on the command line and in Python."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from mehvar.cli.simulate import parse_settings
from mehvar.errors import InputError, bad_value
from mehvar.runtime.batch.plan import Campaign
from mehvar.runtime.model.manifest import find_model


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid")


class Save(_Strict):
    """Which series are stored: one sample every `every` seconds."""

    every: float = Field(gt=0)


class CampaignFile(_Strict):
    """The contents of a campaign file.

    `set` takes parameters, options and choices as `--set` does; `vary` takes distributions as `--vary` does.
    """

    model: str
    controller: str
    n: int = Field(ge=1)
    scenario: str | None = None
    seed: int = Field(default=0, ge=0)
    sampling: Literal["random", "latin", "sobol", "saltelli"] = "random"
    t_end: float | None = Field(default=None, gt=0)
    success: str | None = None
    until: str | None = None
    out: Path | None = None
    save: Save | None = None
    set: dict[str, int | float | str] = {}
    initial: dict[str, float] = {}
    vary: dict[str, str] = {}


def read_campaign(path: Path) -> CampaignFile:
    """Read a campaign file; a relative `model` folder or `out` counts from the file's folder.

    Raises
    ------
    InputError
        For a file that cannot be read, is not TOML, or says something that is not understood; the message names the
        field.
    """
    try:
        data = tomllib.loads(path.read_text(encoding="utf-8-sig"))
        found = CampaignFile.model_validate(data)
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror or error}") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{path} is not TOML: {error}") from error
    except ValidationError as error:
        raise InputError("\n".join(f"{path}: {_sentence(dict(item))}" for item in error.errors())) from error
    folder = path.parent / found.model
    return found.model_copy(
        update={
            "model": str(folder) if (folder / "manifest.json").is_file() else found.model,
            "out": None if found.out is None else path.parent / found.out,
        }
    )


def campaign_of(asked: CampaignFile, origin: str) -> Campaign:
    """Return the campaign that a file or a command line describes."""
    manifest = find_model(asked.model)
    texts = [f"{name}={value}" for name, value in asked.set.items()]
    parameters, options = parse_settings(texts, (*manifest.choices, "profile"))
    for name in ("seed", "backend"):
        if name in options:
            allowed = "given with --seed" if name == "seed" else "left out: a batch runs compiled code"
            raise bad_value(name, options[name], allowed, origin)
    if asked.t_end is not None:
        options["t_end"] = asked.t_end
    return Campaign(
        controller=asked.controller,
        n=asked.n,
        scenario=manifest.scenario(asked.scenario).name,
        seed=asked.seed,
        vary=asked.vary,
        parameters=parameters,
        initial=asked.initial,
        sampling=asked.sampling,
        options=options,
        save_every=None if asked.save is None else asked.save.every,
    )


def _sentence(item: dict[str, object]) -> str:
    """Say field, value and what is allowed from one of pydantic's errors."""
    place = item["loc"]
    field = (
        ".".join(str(part) for part in place if part not in ("int", "float", "str")) if isinstance(place, tuple) else ""
    )
    if item["type"] == "missing":
        return f"{field} is missing"
    if item["type"] == "extra_forbidden":
        return f"{field} is not known; known: {', '.join(CampaignFile.model_fields)}"
    return f"{field} = {item['input']!r}: {item['msg']}"
