# SPDX-License-Identifier: Apache-2.0
"""Traces from a paper's equations to lines of generated C and addresses in an image."""

from __future__ import annotations

import json
import re
from bisect import bisect_right
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from elftools.dwarf.descriptions import describe_form_class
from elftools.elf.elffile import ELFFile

from mehvar.base.names import identifier

from ...model.generated import generated_text
from ...model.model import Model
from ..emulator.profile import line_table
from ..image.elf import Elf
from ..image.instructions import instructions

_STATEMENT = re.compile(r" {4,}(?:const (?:real|mask) )?([A-Za-z_]\w*(?:\[\w+\])?) = ")
_NUMBER = re.compile(r"/\* (\([^)]*\)[^*]*?) \*/\s*$")


@dataclass(frozen=True)
class Traced:
    """A step of a law with its lines and addresses.

    Attributes
    ----------
    number, title : str
        Number of the equation in the paper, and its title; empty for a step without a number in the paper.
    name : str
        Name in the generated code.
    lines : (int, int)
        First and last line in the generated code.
    addresses : tuple of (int, int)
        First and last address of each sequence of instructions that the compiler attributes to these lines.
    instructions : int
        Number of instructions; 0 if the compiler merged the step into another step.
    """

    number: str
    title: str
    name: str
    lines: tuple[int, int]
    addresses: tuple[tuple[int, int], ...]
    instructions: int


def trace(model: Model, law: str, elf: Elf, path: Path) -> list[Traced]:
    """Return the steps of a law in code order.

    Parameters
    ----------
    elf, path
        The image, with its line table.
    """
    symbol = f"{identifier(model.name)}_{identifier(law)}"
    text = generated_text(model.manifest, f"{model.manifest.model}.c")
    titles = _titles(model)
    of_line = _lines(path, symbol, f"{model.manifest.model}.c")
    places: dict[int, list[int]] = {}
    for i in instructions(elf, symbol):
        if line := of_line(i.address):
            places.setdefault(line, []).append(i.address)
    sizes = {i.address: i.size for i in instructions(elf, symbol)}
    result = []
    for number, name, first, last in _statements(text, symbol):
        own = sorted(address for line in range(first, last + 1) for address in places.get(line, ()))
        result.append(Traced(number, titles.get(name, ""), name, (first, last), _runs(own, sizes), len(own)))
    return result


def _titles(model: Model) -> dict[str, str]:
    path = Path(model.manifest.folder) / "equations.json"
    definitions = json.loads(path.read_text(encoding="utf-8"))["definitions"] if path.is_file() else []
    return {identifier(d["name"]): d.get("title", "") for d in definitions}


def _statements(text: str, symbol: str) -> Iterator[tuple[str, str, int, int]]:
    """Yield equation number, name, and first and last line of each statement."""
    lines = text.splitlines()
    begin = next(k for k, line in enumerate(lines) if re.match(rf"void {symbol}\(.*\)$", line))
    first, name = 0, ""
    for k in range(begin + 1, len(lines)):
        line = lines[k]
        if line == "}":
            return
        if match := _STATEMENT.match(line):
            first, name = k + 1, match[1]
        if first and ";" in line:
            number = _NUMBER.search(line)
            yield number[1] if number else "", name, first, k + 1
            first = 0


def _runs(addresses: list[int], sizes: dict[int, int]) -> tuple[tuple[int, int], ...]:
    runs: list[list[int]] = []
    for address in addresses:
        if runs and runs[-1][1] + sizes[runs[-1][1]] == address:
            runs[-1][1] = address
        else:
            runs.append([address, address])
    return tuple((first, last) for first, last in runs)


def _lines(path: Path, symbol: str, file: str) -> Callable[[int], int | None]:
    """Return for each address the line of the law's code, for inlined functions that of the call."""
    rows = line_table(path)
    starts = [address for address, _, _ in rows]
    calls = {at: line for low, high, line in _inlined(path, symbol) for at in range(low, high, 2)}

    def line_at(address: int) -> int | None:
        _, name, line = rows[bisect_right(starts, address) - 1]
        return calls.get(address, line if name == file else None)

    return line_at


def _inlined(path: Path, symbol: str) -> Iterator[tuple[int, int, int]]:
    """Yield the address ranges of functions inlined into a function, with the lines of their calls."""
    with path.open("rb") as stream:
        dwarf = ELFFile(stream).get_dwarf_info()
        for unit in dwarf.iter_CUs():
            for die in unit.iter_DIEs():
                if die.tag != "DW_TAG_subprogram" or "DW_AT_low_pc" not in die.attributes:
                    continue
                if _name(die) == symbol:
                    yield from _calls(dwarf, unit, die)


def _name(die: Any) -> str:
    if "DW_AT_name" in die.attributes:
        return str(die.attributes["DW_AT_name"].value.decode())
    if "DW_AT_abstract_origin" in die.attributes:
        return _name(die.get_DIE_from_attribute("DW_AT_abstract_origin"))
    return ""


def _calls(dwarf: Any, unit: Any, die: Any) -> Iterator[tuple[int, int, int]]:
    for child in die.iter_children():
        if child.tag == "DW_TAG_inlined_subroutine":
            line = child.attributes["DW_AT_call_line"].value
            for low, high in _ranges(dwarf, unit, child):
                yield low, high, line
        elif child.tag == "DW_TAG_lexical_block":
            yield from _calls(dwarf, unit, child)


def _ranges(dwarf: Any, unit: Any, die: Any) -> Iterator[tuple[int, int]]:
    """Yield start and end of the address ranges of an entry in DWARF."""
    attributes = die.attributes
    if "DW_AT_low_pc" in attributes:
        low, high = attributes["DW_AT_low_pc"].value, attributes["DW_AT_high_pc"]
        yield low, high.value if describe_form_class(high.form) == "address" else low + high.value
    elif "DW_AT_ranges" in attributes:
        lists = dwarf.range_lists()
        base = unit.get_top_DIE().attributes.get("DW_AT_low_pc")
        start = base.value if base else 0
        for entry in lists.get_range_list_at_offset(attributes["DW_AT_ranges"].value, unit):
            if hasattr(entry, "base_address"):
                start = entry.base_address
            else:
                offset = 0 if getattr(entry, "is_absolute", False) else start
                yield offset + entry.begin_offset, offset + entry.end_offset
