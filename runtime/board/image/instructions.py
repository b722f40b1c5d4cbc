# SPDX-License-Identifier: Apache-2.0
"""Instructions of images for Cortex-M and RISC-V: names, changed registers, jump targets, use of the stack."""

from __future__ import annotations

import functools
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import capstone
from capstone import arm_const

from mehvar.base.errors import MehvarError

from .elf import Elf

_CONDITION = re.compile(r"s?(eq|ne|hs|cs|lo|cc|mi|pl|vs|vc|hi|ls|ge|lt|gt|le)")
_PUSHES = ("push", "vpush", "stmdb", "vstmdb")
_KEEP_THE_STACK = ("add", "addw", "pop", "vpop", "ldm", "vldm", "vldmia", "cmp", "tst")
_PREDECREMENT = re.compile(r"\[sp, #-(0x[0-9a-f]+|\d+)\]!")
_DESCENT = re.compile(r"sp, (?:sp, )?#(0x[0-9a-f]+|\d+)$")
_RISCV_BRANCH = re.compile(r"b(eq|ne|lt|ge|ltu|geu|gt|le|gtu|leu|eqz|nez|lez|gez|ltz|gtz)")
_RISCV_OFFSET = re.compile(r"-?(0x[0-9a-f]+|\d+)$")
_RISCV_DESCENT = re.compile(r"(?:addi|addi16sp) sp, (?:sp, )?(-?(?:0x[0-9a-f]+|\d+))")
_RISCV_FRAME = re.compile(r"(add|addi|sub|mv|andi?|l[dw]) sp,")
_CODE = 2**32
_UNKNOWN = "unknown"


class UnboundedError(MehvarError, ValueError):
    """Error for a function whose instructions do not determine its length or stack."""


@dataclass(frozen=True)
class Instruction:
    """An instruction: address, text, jump target, changed registers, condition of an IT block or branch."""

    address: int
    size: int
    mnemonic: str
    operands: str
    target: int | None = None
    writes: frozenset[str] = frozenset()
    condition: str = ""

    @property
    def name(self) -> str:
        """The mnemonic without condition and types."""
        return self.mnemonic.split(".")[0].removesuffix(self.condition)

    @property
    def conditional(self) -> bool:
        """True for a conditional branch."""
        return self.name in ("cbz", "cbnz") or (self.name == "b" and self.condition != "")

    @property
    def returns_if(self) -> bool:
        """True for an instruction of an IT block that may return."""
        return self.condition != "" and self.returns

    @property
    def exact(self) -> bool:
        """True for a test of equality, whose value a loop counter must reach exactly."""
        return self.name.startswith("cb") or self.condition in ("eq", "ne")

    @property
    def call(self) -> bool:
        """True for a call."""
        return self.name in ("bl", "blx")

    @property
    def leaves(self) -> bool:
        """True if only jumps reach the following instruction."""
        if self.call or self.conditional or self.returns_if:
            return False
        return self.name in ("b", "bx", "udf") or "pc" in self.writes or "pc}" in self.operands

    @property
    def returns(self) -> bool:
        """True if the instruction ends a function."""
        return (self.name == "bx" and self.operands == "lr") or (
            self.name.startswith(("pop", "ldm", "ldr")) and "pc" in self.operands and "[pc" not in self.operands
            and "[r" not in self.operands
        ) or self.name == "udf"  # fmt: skip

    @property
    def indirect(self) -> bool:
        """True for a call or a jump to an address in a register."""
        return self.target is None and (self.call or (self.leaves and not self.returns))

    @property
    def registers(self) -> int:
        """Number of registers in a list such as {r4, r6-r8}."""
        names = self.operands[self.operands.find("{") + 1 : self.operands.find("}")]
        count = 0
        for part in names.split(","):
            first, dash, last = part.strip().partition("-")
            count += int(last.strip()[1:]) - int(first.strip()[1:]) + 1 if dash else 1
        return count

    @property
    def descent(self) -> int | None:
        """Bytes by which the instruction lowers the stack pointer; None for a variable number."""
        if self.name in _PUSHES and (self.name.endswith("push") or self.operands.startswith("sp!")):
            return (8 if "{d" in self.operands else 4) * self.registers
        if match := _PREDECREMENT.search(self.operands):
            return int(match[1], 0)
        if not self.operands.startswith(("sp, ", "sp!")) or self.name in _KEEP_THE_STACK:
            return 0
        size = _DESCENT.search(self.operands) if self.name in ("sub", "subw") else None
        return int(size[1], 0) if size else None


class RiscV(Instruction):
    """An instruction of RISC-V, whose loops are not counted."""

    @property
    def name(self) -> str:
        """The mnemonic without the mark of a short encoding."""
        return self.mnemonic.removeprefix("c.")

    @property
    def conditional(self) -> bool:
        """True for a conditional branch."""
        return _RISCV_BRANCH.fullmatch(self.name) is not None

    @property
    def call(self) -> bool:
        """True for a call."""
        return self.name in ("jal", "jalr") and not self.operands.startswith("zero,")

    @property
    def leaves(self) -> bool:
        """True if only jumps reach the following instruction."""
        return not self.call and self.name in ("j", "jal", "jr", "jalr", "ret", "ebreak", "unimp")

    @property
    def returns(self) -> bool:
        """True if the instruction ends a function."""
        return self.name in ("ret", "ebreak", "unimp") or (self.name == "jr" and self.operands == "ra")

    @property
    def descent(self) -> int | None:
        """Bytes by which the instruction lowers the stack pointer; None for a variable number."""
        text = f"{self.name} {self.operands}"
        if match := _RISCV_DESCENT.fullmatch(text):
            return max(0, -int(match[1], 0))
        return None if _RISCV_FRAME.match(text) else 0


def instructions(elf: Elf, name: str) -> list[Instruction]:
    """Return the instructions of a function without constants between them.

    Raises
    ------
    UnboundedError
        If the decoder does not know one.
    """
    own = [i for address, size in elf.functions[name] for i in decoded(elf.stored(address, size), address, elf.riscv)]
    for i in own:
        if i.mnemonic == _UNKNOWN:
            raise UnboundedError(f"an instruction at {i.address:#010x} is unknown")
    return own


@functools.cache
def decoded(code: bytes, address: int, riscv: bool = False) -> tuple[Instruction, ...]:
    """Return the instructions of code, also those that the decoder does not know."""
    engine, read = _engine(riscv), _riscv if riscv else _arm
    return tuple(
        read(i) if i.id else Instruction(i.address, i.size, _UNKNOWN, "") for i in engine.disasm(code, address)
    )


@functools.cache
def _engine(riscv: bool) -> Any:
    """Return the decoder, which steps over unknown instructions."""
    if riscv:
        engine = capstone.Cs(capstone.CS_ARCH_RISCV, capstone.CS_MODE_RISCV64 | capstone.CS_MODE_RISCVC)
    else:
        engine = capstone.Cs(capstone.CS_ARCH_ARM, capstone.CS_MODE_THUMB | capstone.CS_MODE_MCLASS)
        engine.detail = True
    engine.skipdata_setup = (_UNKNOWN, None if riscv else _thumb_size, None)
    engine.skipdata = True
    return engine


def _thumb_size(code: Sequence[bytes], _size: int, at: int, _data: object) -> int:
    """Return the bytes of an instruction, which its first half-word decides."""
    return 4 if code[at + 1][0] >> 3 in (0b11101, 0b11110, 0b11111) else 2


def _riscv(i: Any) -> Instruction:
    plain = RiscV(i.address, i.size, i.mnemonic, i.op_str)
    offset = _RISCV_OFFSET.search(i.op_str) if plain.conditional or plain.name in ("j", "jal") else None
    return RiscV(i.address, i.size, i.mnemonic, i.op_str, i.address + int(offset[0], 0)) if offset else plain


def _arm(i: Any) -> Instruction:
    writes = frozenset(i.reg_name(register) for register in i.regs_access()[1])
    condition = _CONDITION.fullmatch(i.mnemonic.split(".")[0].removeprefix(i.insn_name()))
    target = None
    if i.insn_name() in ("b", "bl", "blx", "cbz", "cbnz"):
        last = i.operands[-1]
        target = last.imm % _CODE if last.type == arm_const.ARM_OP_IMM else None
    return Instruction(i.address, i.size, i.mnemonic, i.op_str, target, writes, condition[1] if condition else "")
