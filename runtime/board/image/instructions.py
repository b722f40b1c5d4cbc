# SPDX-License-Identifier: Apache-2.0
"""Instructions of images for Cortex-M and RISC-V: names, changed registers, jump targets."""

from __future__ import annotations

import functools
import re
from dataclasses import dataclass
from typing import Any

import capstone
from capstone import arm_const

from mehvar.base.errors import MehvarError

from .elf import Elf

_CONDITIONS = ("eq", "ne", "hs", "cs", "lo", "cc", "mi", "pl", "vs", "vc", "hi", "ls", "ge", "lt", "gt", "le")
_CONDITIONAL = re.compile(rf"b({'|'.join(_CONDITIONS)})(\.w)?|cbn?z")
_RETURN_IF = re.compile(rf"(bx|pop|ldm\w*?)({'|'.join(_CONDITIONS)})(\.w)?")
_RISCV_BRANCH = re.compile(r"(c\.)?b(eq|ne|lt|ge|ltu|geu|gt|le|gtu|leu|eqz|nez|lez|gez|ltz|gtz)")
_RISCV_OFFSET = re.compile(r"-?(0x[0-9a-f]+|\d+)$")
_CODE = 2**32


class UnboundedError(MehvarError, ValueError):
    """Error for a function whose instructions do not determine its length or stack."""


@dataclass(frozen=True)
class Instruction:
    """An instruction: address, text, jump target, changed registers."""

    address: int
    size: int
    mnemonic: str
    operands: str
    target: int | None
    writes: frozenset[str]

    @property
    def conditional(self) -> bool:
        """True for a conditional branch."""
        return _CONDITIONAL.fullmatch(self.mnemonic) is not None

    @property
    def returns_if(self) -> bool:
        """True for an instruction of an IT block that may return."""
        if _RETURN_IF.fullmatch(self.mnemonic) is None:
            return False
        return self.operands == "lr" or "pc}" in self.operands

    @property
    def exact(self) -> bool:
        """True for a test of equality, whose value a loop counter must reach exactly."""
        return self.mnemonic.startswith("cb") or self.mnemonic.split(".")[0].endswith(("eq", "ne"))

    @property
    def call(self) -> bool:
        """True for a call."""
        return self.mnemonic in ("bl", "blx")

    @property
    def leaves(self) -> bool:
        """True if only jumps reach the following instruction."""
        if self.call or self.conditional or self.returns_if:
            return False
        return self.mnemonic in ("b", "b.w", "bx", "udf") or "pc" in self.writes or "pc}" in self.operands

    @property
    def returns(self) -> bool:
        """True if the instruction ends a function."""
        return (self.mnemonic == "bx" and self.operands == "lr") or (
            self.mnemonic.startswith(("pop", "ldm", "ldr")) and "pc" in self.operands and "[pc" not in self.operands
            and "[r" not in self.operands
        ) or self.mnemonic == "udf"  # fmt: skip


class RiscV(Instruction):
    """An instruction of RISC-V, whose loops are not counted."""

    @property
    def conditional(self) -> bool:
        """True for a conditional branch."""
        return _RISCV_BRANCH.fullmatch(self.mnemonic) is not None

    @property
    def returns_if(self) -> bool:
        """False: no instruction returns conditionally."""
        return False

    @property
    def call(self) -> bool:
        """True for a call."""
        name = self.mnemonic.removeprefix("c.")
        return (name == "jal" and not self.operands.startswith("zero,")) or (name == "jalr" and not self._plain)

    @property
    def leaves(self) -> bool:
        """True if only jumps reach the following instruction."""
        name = self.mnemonic.removeprefix("c.")
        return not self.call and name in ("j", "jal", "jr", "jalr", "ret", "ebreak", "unimp")

    @property
    def returns(self) -> bool:
        """True if the instruction ends a function."""
        name = self.mnemonic.removeprefix("c.")
        return name in ("ret", "ebreak", "unimp") or (name == "jr" and self.operands == "ra")

    @property
    def _plain(self) -> bool:
        return self.operands.startswith("zero,")


def instructions(elf: Elf, name: str) -> list[Instruction]:
    """Return the instructions of a function without constants between them."""
    decoded = _decoded_riscv if elf.riscv else _decoded
    return [i for address, size in elf.functions[name] for i in decoded(elf.stored(address, size), address)]


@functools.cache
def _decoded_riscv(code: bytes, address: int) -> tuple[Instruction, ...]:
    """Return the instructions of RISC-V code; refuse code that the decoder does not know in full."""
    engine = capstone.Cs(capstone.CS_ARCH_RISCV, capstone.CS_MODE_RISCV64 | capstone.CS_MODE_RISCVC)
    decoded = []
    for at, size, mnemonic, operands in engine.disasm_lite(code, address):
        name = mnemonic.removeprefix("c.")
        target = None
        if (name in ("j", "jal") or _RISCV_BRANCH.fullmatch(mnemonic)) and (match := _RISCV_OFFSET.search(operands)):
            target = at + int(match[0], 0)
        decoded.append(RiscV(at, size, mnemonic, operands, target, frozenset()))
    if sum(i.size for i in decoded) != len(code):
        raise UnboundedError(f"an instruction at {address + sum(i.size for i in decoded):#010x} is unknown")
    return tuple(decoded)


@functools.cache
def _decoded(code: bytes, address: int) -> tuple[Instruction, ...]:
    engine = capstone.Cs(capstone.CS_ARCH_ARM, capstone.CS_MODE_THUMB | capstone.CS_MODE_MCLASS)
    engine.detail = True
    return tuple(map(_instruction, engine.disasm(code, address)))


def _instruction(i: Any) -> Instruction:
    writes = frozenset(i.reg_name(register) for register in i.regs_access()[1])
    target = None
    if i.mnemonic.split(".")[0] in ("b", "bl", "blx") or _CONDITIONAL.fullmatch(i.mnemonic):
        last = i.operands[-1]
        target = last.imm % _CODE if last.type == arm_const.ARM_OP_IMM else None
    return Instruction(i.address, i.size, i.mnemonic, i.op_str, target, writes)
