# SPDX-License-Identifier: Apache-2.0
"""Cost of a step on the board: exact instruction counts, estimated cycles, executed lines.

The image is the one for flashing, without instrumentation, because the emulator reports the blocks that it runs.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from elftools.elf.elffile import ELFFile

from ..image.elf import Elf
from ..image.instructions import Instruction, decoded
from .machine import EmulatedBoard

STEP = "mv_app_step"
_NOT_THE_LAW = ("mv_server_", "mv_link_", "mv_board_", "main", "Reset_", "Default_", "mv_app_selftest")
_TAKEN = 2
"""Cycles of the pipeline refill after a taken branch, the middle of the manual's range, 1 to 3."""
_CYCLES = {"vdiv": 14, "vsqrt": 14, "vfma": 3, "vfms": 3, "vmla": 3, "vmls": 3, "vnmla": 3, "vnmls": 3, "vmrs": 1,
           "vldr": 2, "vstr": 2, "ldr": 2, "ldrb": 2, "ldrh": 2, "str": 2, "strb": 2, "udiv": 7, "sdiv": 7}  # fmt: skip
"""Cycles of instructions according to the Cortex-M4 Technical Reference Manual; all others take one cycle."""
_PER_REGISTER = ("ldm", "stm", "push", "pop", "vldm", "vstm", "vpush", "vpop")


@dataclass
class Profile:
    """Counts over all steps.

    Attributes
    ----------
    most, least : int
        Largest and smallest number of instructions of a step.
    cycles : int
        Cycles of the longest step, estimated for a Cortex-M4F without wait states.
    steps : int
        Number of counted steps.
    addresses : set of int
        Instructions that ran.
    """

    most: int = 0
    least: int = 0
    cycles: int = 0
    steps: int = 0
    addresses: set[int] = field(default_factory=set)


class StepProfiler:
    """Observer of a machine that counts the instructions of steps.

    Call `count` after each exchange; the first call determines the return address of a step.
    """

    def __init__(self, machine: EmulatedBoard, elf: Elf, cycles: bool) -> None:
        self.profile = Profile()
        self._machine, self._elf, self._cycles = machine, elf, cycles
        self._entry, _ = elf.symbols[STEP]
        self._return: int | None = None
        self._inside = False
        self._blocks: list[tuple[int, int]] = []
        self._lengths: dict[tuple[int, int], int] = {}
        machine.on_range(self._entry, self._entry, self._find_return)

    def _find_return(self, _address: int, _size: int) -> None:
        self._return = self._machine.link_register()

    def _begin(self, address: int, size: int) -> None:
        if address == self._entry:
            self._inside = True
            self._blocks.clear()
        elif address == self._return:
            self._inside = False
        if self._inside:
            self._blocks.append((address, size))

    def count(self) -> None:
        """Add the last step to the counts."""
        if self._return is None:
            return
        if not self.profile.steps and not self._blocks:
            self._watch()
            return
        profile, blocks = self.profile, self._blocks
        if not blocks:
            return
        instructions = sum(map(self._length, blocks))
        profile.steps += 1
        profile.least = min(profile.least or instructions, instructions)
        if instructions > profile.most:
            profile.most = instructions
            profile.cycles = self._estimate(blocks) if self._cycles else 0
        blocks.clear()

    def _length(self, block: tuple[int, int]) -> int:
        """Return the number of instructions in a block, and at first use record them as executed."""
        if block not in self._lengths:
            instructions = self._instructions(*block)
            self.profile.addresses.update(i.address for i in instructions)
            self._lengths[block] = len(instructions)
        return self._lengths[block]

    def close(self) -> None:
        """Stop watching."""
        self._machine.unhook()

    def _watch(self) -> None:
        assert self._return is not None
        self._machine.unhook()
        self._machine.on_range(self._return, self._return, self._begin)
        for address, size in self._functions():
            self._machine.on_range(address, address + size - 1, self._begin)

    def _functions(self) -> list[tuple[int, int]]:
        """Return the addresses of all functions that a step may call."""
        ranges: list[tuple[int, int]] = []
        places = {place for name, place in self._elf.symbols.items() if not name.startswith(_NOT_THE_LAW)}
        for address, size in sorted(places, key=lambda place: (place[0], -place[1])):
            end = sum(ranges[-1]) if ranges else 0
            first = max(address, end)
            if address + size > first and self._in_flash(address):
                ranges.append((first, address + size - first))
        return ranges

    def _in_flash(self, address: int) -> bool:
        return any(start <= address < start + len(content) for start, content in self._elf.segments)

    def _estimate(self, blocks: list[tuple[int, int]]) -> int:
        cycles = 0
        for block, following in zip(blocks, [*blocks[1:], (0, 0)], strict=True):
            cycles += sum(map(_cost, self._instructions(*block)))
            cycles += _TAKEN * (following[0] != block[0] + block[1])
        return cycles

    def _instructions(self, address: int, size: int) -> tuple[Instruction, ...]:
        return decoded(self._elf.stored(address, size), address)


def _cost(i: Instruction) -> int:
    if i.name.startswith(_PER_REGISTER):
        return 1 + i.registers
    return next((cycles for name, cycles in _CYCLES.items() if i.name.startswith(name)), 1)


@dataclass(frozen=True)
class Coverage:
    """Lines of a function in a source file, with code and executed."""

    function: str
    lines: int
    run: int
    missed: tuple[int, ...]


def coverage(path: Path, elf: Elf, functions: list[str], addresses: set[int]) -> list[Coverage]:
    """Return the executed lines of each function.

    Parameters
    ----------
    path : Path
        The image, with its line table.
    functions : list of str
        Their names.
    addresses : set of int
        Instructions that ran.
    """
    rows = line_table(path)
    result = []
    for name in functions:
        start, size = elf.symbols[name]
        own = [(address, file, line) for address, file, line in rows if start <= address < start + size]
        main = Counter(file for _, file, _ in own).most_common(1)
        lines: dict[int, bool] = {}
        for (address, file, line), (following, _, _) in zip(own, [*own[1:], (start + size, "", 0)], strict=True):
            if file == main[0][0] and line and following > address:
                lines[line] = lines.get(line, False) or any(a in addresses for a in range(address, following, 2))
        missed = tuple(sorted(line for line, ran in lines.items() if not ran))
        result.append(Coverage(name, len(lines), len(lines) - len(missed), missed))
    return result


def line_table(path: Path) -> list[tuple[int, str, int]]:
    """Return address, file and line of each row in an image's line table, by address."""
    rows = []
    with path.open("rb") as file:
        dwarf = ELFFile(file).get_dwarf_info()
        for unit in dwarf.iter_CUs():
            program = dwarf.line_program_for_CU(unit)
            if program is None:
                continue
            names = program["file_entry"]
            first = 0 if program["version"] >= 5 else 1
            for entry in program.get_entries():
                state = entry.state
                if state and not state.end_sequence:
                    rows.append((state.address, names[state.file - first].name.decode(), state.line))
    return sorted(rows)
