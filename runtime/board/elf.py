# SPDX-License-Identifier: Apache-2.0
"""What is in a compiled image: segments, symbols, sizes, and routines that a float image must not have."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from elftools.elf.elffile import ELFFile

_DOUBLE = re.compile(
    r"__(aeabi_(d\w+|[a-z0-9]+2d|cd\w+)|(add|sub|mul|div|neg|cmp|eq|ne|lt|le|gt|ge|unord)df[23]?\w*"
    r"|(extendsf|trunc|fix\w*|float\w*)df\w*|\w*sfdf2|truncdfsf2)"
    r"|(a?(sin|cos|tan)h?|atan2|exp|expm1|log|log1p|pow|sqrt|fmod|hypot|erf|floor|ceil|fabs)"
)


@dataclass(frozen=True)
class Elf:
    """An image as loaded into memory.

    Attributes
    ----------
    segments : tuple of (int, bytes)
        Address and content of what is stored in flash.
    symbols : dict of str to (int, int)
        Address (of code: without the Thumb bit) and size.
    flash, ram : int
        Bytes in flash; bytes of static data, without the stack.
    stack : int
        Bytes reserved for the stack.
    """

    segments: tuple[tuple[int, bytes], ...]
    symbols: dict[str, tuple[int, int]]
    flash: int
    ram: int
    stack: int

    def doubles(self) -> list[str]:
        """Return the routines in double precision that the image holds."""
        return sorted(name for name in self.symbols if _DOUBLE.fullmatch(name))


def read_elf(path: Path) -> Elf:
    """Read an image for a board."""
    with path.open("rb") as file:
        elf = ELFFile(file)
        segments = tuple(
            (s["p_paddr"], s.data()) for s in elf.iter_segments() if s["p_type"] == "PT_LOAD" and s["p_filesz"]
        )
        table = elf.get_section_by_name(".symtab")
        symbols = {
            s.name: (s["st_value"] & ~1 if s["st_info"]["type"] == "STT_FUNC" else s["st_value"], s["st_size"])
            for s in table.iter_symbols()
            if s.name and not s.name.startswith("$") and s["st_info"]["type"] != "STT_FILE"
        }
        sizes = {s.name: s["sh_size"] for s in elf.iter_sections() if s["sh_flags"] & 2}
    stack = sizes.pop(".stack", 0)
    if not stack:
        stack = symbols["__stack_top"][0] - symbols["__stack_limit"][0]
    ram = sizes.pop(".bss", 0) + sizes.get(".data", 0)
    return Elf(segments, symbols, sum(sizes.values()), ram, stack)
