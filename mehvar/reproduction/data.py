# SPDX-License-Identifier: Apache-2.0
"""Strict reader for a paper's data files: captions, claims, studies and tables of expected numbers."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import TypeVar

from mehvar.base.errors import InputError
from mehvar.base.schema import SchemaError, parse_toml, read

Data = TypeVar("Data")


def read_data(path: Path, kind: type[Data]) -> Data:
    """Read a TOML file as a dataclass.

    Parameters
    ----------
    path : Path
        The file.
    kind : type
        The dataclass.

    Raises
    ------
    InputError
        For a file that cannot be read, is not TOML, or has a field that is missing, unknown or of the wrong kind; the
        message names file and field.
    """
    try:
        return read(kind, parse_toml(path.read_text(encoding="utf-8")), "table")
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror or error}") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{path} is not TOML: {error}") from error
    except SchemaError as error:
        raise InputError(f"{path}: {error}") from error
