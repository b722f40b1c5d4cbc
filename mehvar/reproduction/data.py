# SPDX-License-Identifier: Apache-2.0
"""Strict reader for a paper's data files: captions, claims, studies and tables of expected numbers."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import ClassVar, TypeVar

from pydantic import ConfigDict, TypeAdapter, ValidationError

from mehvar.base.errors import InputError
from mehvar.base.schema import parse_toml

Data = TypeVar("Data")


class FileTable:
    """Base of dataclasses for the tables of a data file, which refuse unknown fields."""

    __pydantic_config__: ClassVar[ConfigDict] = {"extra": "forbid"}


def read_data(path: Path, kind: type[Data]) -> Data:
    """Read a TOML file as a dataclass.

    Parameters
    ----------
    path : Path
        The file.
    kind : type
        The dataclass, a `FileTable`.

    Raises
    ------
    InputError
        For a file that cannot be read, is not TOML, or has a field that is missing, unknown or of the wrong kind; the
        message names file and field.
    """
    try:
        content = parse_toml(path.read_text(encoding="utf-8"))
        return TypeAdapter(kind).validate_python(content)
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror or error}") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{path} is not TOML: {error}") from error
    except ValidationError as error:
        raise InputError("\n".join(f"{path}: {_place(e['loc'])}: {e['msg']}" for e in error.errors())) from error


def _place(steps: tuple[int | str, ...]) -> str:
    """Return a field's place in the file, with list entries counted from one: "figure 3, caption"."""
    return "".join(f" {step + 1}" if isinstance(step, int) else f", {step}" for step in steps).removeprefix(", ")
