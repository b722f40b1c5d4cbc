# SPDX-License-Identifier: Apache-2.0
"""Definitions that C and Python share: structures field by field, and the numbers behind names."""

from __future__ import annotations

import ctypes
import re

import pytest

from mehvar.base.manifest import METRIC_KINDS
from mehvar.runtime.compiling.library import NATIVE, load_library, native_headers, native_sources
from mehvar.runtime.compiling.structures import structures
from mehvar.runtime.run.options import INTEGRATORS
from mehvar.runtime.run.problem import STAGES, Status

HEADERS = ("step/schedule.h", "single/single.h", "batch/job.h", "methods/tableaux.h")
STRUCTURES = structures(*HEADERS)
ENUMERATIONS = {
    ("step/schedule.h", "mv_status"): {status.name: status.value for status in Status},
    ("methods/tableaux.h", "mv_method"): INTEGRATORS,
    ("batch/job.h", "mv_kind"): METRIC_KINDS,
}


def text(header: str) -> str:
    return (NATIVE / header).read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def layout() -> ctypes.CDLL:
    """For each structure its size, then offset and size of every field, as the compiler has them."""
    lines = ["#include <stddef.h>", *(f'#include "{header.rpartition("/")[2]}"' for header in HEADERS)]
    for name, structure in STRUCTURES.items():
        numbers = [f"sizeof({name})"]
        for field, *_ in structure._fields_:
            numbers += [f"offsetof({name}, {field})", f"sizeof((({name} *)0)->{field})"]
        lines.append(f"const size_t layout_{name}[] = {{{', '.join(numbers)}}};")
    sources = native_headers() | native_sources(*HEADERS) | {"layout.c": "\n".join([*lines, ""])}
    return load_library("layout", sources, ["layout.c"])


@pytest.mark.parametrize("name", STRUCTURES)
def test_a_structure_has_the_fields_that_c_has(name: str, layout: ctypes.CDLL) -> None:
    structure = STRUCTURES[name]
    fields = [getattr(structure, field) for field, *_ in structure._fields_]
    expected = [ctypes.sizeof(structure), *(number for field in fields for number in (field.offset, field.size))]
    assert list((ctypes.c_size_t * len(expected)).in_dll(layout, f"layout_{name}")) == expected


def test_every_structure_of_the_headers_is_there() -> None:
    assert set(STRUCTURES) == {name for header in HEADERS for name in re.findall(r"^\} (\w+);", text(header), re.M)}


@pytest.mark.parametrize(("header", "name"), ENUMERATIONS)
def test_names_have_the_numbers_that_c_gives_them(header: str, name: str) -> None:
    match = re.search(rf"enum {name} \{{(.*?)\}}", text(header), re.DOTALL)
    assert match is not None
    words = ENUMERATIONS[header, name]
    expected = words if isinstance(words, dict) else {word: number for number, word in enumerate(words)}
    members: dict[str, int] = {}
    for member in filter(None, map(str.strip, re.sub(r"/\*.*?\*/", "", match[1], flags=re.DOTALL).split(","))):
        word, _, number = member.partition(" = ")
        members[word] = int(number) if number else max(members.values(), default=-1) + 1
    assert members == {f"MV_{word.upper()}": number for word, number in expected.items()}


def test_the_rows_of_a_tableau_have_the_length_that_python_takes() -> None:
    assert f"#define MV_STAGES {STAGES} " in text("methods/tableaux.h")
