# SPDX-License-Identifier: Apache-2.0
"""Check that names, positions and sizes in generated C and Python match the manifest.

A run allocates its arrays by the manifest. Code with other sizes would write beyond them, and code with another order
would confuse states.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from types import ModuleType

from mehvar.base.constants import constants, vectors
from mehvar.base.errors import InputError
from mehvar.base.manifest import FILE, Manifest

from .generated import generated_text

_COMMENT = re.compile(r"/\*.*?\*/", re.DOTALL)
_CONSTANT = re.compile(r"(\w+) = (\d+)")


def check_header(manifest: Manifest) -> None:
    """Refuse a header whose constants or hash differ from the manifest.

    Raises
    ------
    InputError
        Naming the constant and both values.
    """
    path = manifest.folder / f"{manifest.model}.h"
    text = _COMMENT.sub("", generated_text(manifest, path.name))
    present: dict[str, object] = {name: int(value) for name, value in _CONSTANT.findall(text)}
    _compare(path, present, dict(constants(manifest)))
    if f'{manifest.model.upper()}_HASH "{manifest.hash}"' not in text:
        raise _error(path, "hash", "another", manifest.hash)


def check_module(manifest: Manifest, module: ModuleType, path: Path) -> None:
    """Refuse a generated Python module whose names, sizes or hash differ from the manifest.

    A module of an older version may have more functions.
    """
    sizes = getattr(module, "SIZES", {})
    present = {vector.constant: getattr(module, vector.constant, None) for vector in vectors(manifest)}
    expected: dict[str, object] = {vector.constant: vector.names for vector in vectors(manifest)}
    for f in (f for f in manifest.functions.values() if manifest.module_of(f) == path.name):
        name = f"SIZES[{f.name!r}]"
        expected[name] = {array.name: array.length for array in (*f.arguments, *f.results)}
        present[name] = sizes.get(f.name)
    _compare(path, present, expected)
    if getattr(module, "HASH", None) != manifest.hash:
        raise _error(path, "HASH", getattr(module, "HASH", None), manifest.hash)


def _compare(path: Path, present: Mapping[str, object], expected: Mapping[str, object]) -> None:
    for name in (*expected, *present):
        if present.get(name) != expected.get(name):
            raise _error(path, name, present.get(name, "nothing"), expected.get(name, "nothing"))


def _error(path: Path, name: str, present: object, expected: object) -> InputError:
    return InputError(
        f"{path}: {name} is {present}, and {FILE} says {expected}: code and manifest are of different models; "
        "generate the model again"
    )
