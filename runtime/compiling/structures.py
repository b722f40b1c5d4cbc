# SPDX-License-Identifier: Apache-2.0
"""`ctypes` structures from the headers in `native`."""

from __future__ import annotations

import ctypes
import re
from typing import Any

from .library import NATIVE

_TYPES: dict[str, Any] = {
    "int": ctypes.c_int,
    "int32_t": ctypes.c_int32,
    "int64_t": ctypes.c_int64,
    "uint64_t": ctypes.c_uint64,
    "double": ctypes.c_double,
}
_STRUCTURE = re.compile(r"typedef struct \{(.*?)\} (\w+);", re.DOTALL)
_FIELDS = re.compile(r"(?:const )?(?:volatile )?(\w+) ([^;]+);")


def structures(*headers: str) -> dict[str, Any]:
    """Return the structures of headers by C name; a header may use structures of previous ones.

    Pointers become `c_void_p`. A structure has numbers, pointers and other structures as fields, and no arrays.
    """
    types = dict(_TYPES)
    for header in headers:
        text = re.sub(r"/\*.*?\*/", "", (NATIVE / header).read_text(encoding="utf-8"), flags=re.DOTALL)
        for body, name in _STRUCTURE.findall(text):
            types[name] = type(name, (ctypes.Structure,), {"_fields_": _fields(body, types)})
    return {name: kind for name, kind in types.items() if name not in _TYPES}


def _fields(body: str, types: dict[str, Any]) -> list[tuple[str, Any]]:
    return [
        (re.findall(r"\w+", declarator)[0], ctypes.c_void_p if "*" in declarator else types[name])
        for name, declarators in _FIELDS.findall(body)
        for declarator in declarators.split(",")
    ]
