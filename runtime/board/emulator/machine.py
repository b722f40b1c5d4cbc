# SPDX-License-Identifier: Apache-2.0
"""Emulated board: Unicorn runs the complete image with its drivers, and this module simulates the hardware.

Time advances only by `advance`, so that runs are reproducible.
"""

from __future__ import annotations

import struct
from collections import deque
from collections.abc import Callable
from typing import Any

import unicorn
from unicorn import arm_const

from mehvar.base.errors import InputError

from ..image.elf import Elf
from ..image.toolchains import Board
from ..line.link import LinkError

_CPUS = {
    "m3": arm_const.UC_CPU_ARM_CORTEX_M3,
    "m4f": arm_const.UC_CPU_ARM_CORTEX_M4,
    "m7": arm_const.UC_CPU_ARM_CORTEX_M7,
}
_PAGE = 0x1000
_PERIPHERALS = (0x40000000, 0x24000)
_SYSTEM = (0xE000E000, _PAGE)
_SYST_CSR, _SYST_RVR, _SYST_CVR, _AIRCR = 0x10, 0x14, 0x18, 0xD0C
_RESET_KEY = 0x05FA0004  # VECTKEY and SYSRESETREQ of the Armv7-M architecture
_NOWHERE = 0xFFFFFFFE
_DEBUG = (0xE0042000, _PAGE)
_RCC_CR, _RCC_CFGR = 0x23800, 0x23808
_TIM3_CCR = (0x434, 0x438, 0x43C)
_IWDG_KR, _IWDG_PR, _IWDG_RLR = 0x3000, 0x3004, 0x3008
_IWDG_START, _IWDG_RELOAD, _IWDG_HERTZ = 0xCCCC, 0xAAAA, 32_000
_HSI_ON_AND_READY, _PLL_ON = 0x83, 1 << 24
_STEP_MS = 20
"""Milliseconds per emulation step, so that a 24-bit counter, which overflows after 99.9 ms at 168 MHz, overflows at
most once.
"""

Hook = Callable[[int, int], None]
"""Function called before each block of instructions, with its address and size."""


class EmulatedBoard:
    """A board under Unicorn.

    Parameters
    ----------
    elf : Elf
        Image for `board`.
    board : Board
        Its memory and registers.
    """

    def __init__(self, elf: Elf, board: Board) -> None:
        self._elf, self._board = elf, board
        self._to_board: deque[int] = deque()
        self._from_board = bytearray()
        self._ticks = 0
        self._reload, self._wrapped = 0xFFFFFF, False
        self._reboot = False
        self._hooks: list[int] = []
        self.watchdog: int | None = None
        """Ticks of the last reload of the independent watchdog; None before its start."""
        self.registers: dict[int, int] = {}
        """Values in peripheral registers without simulated behaviour."""
        self.clock_control = {_RCC_CR: _HSI_ON_AND_READY, _RCC_CFGR: 0}
        self._uc = unicorn.Uc(unicorn.UC_ARCH_ARM, unicorn.UC_MODE_THUMB | unicorn.UC_MODE_MCLASS)
        self._uc.ctl_set_cpu_model(_CPUS[board.cpu])
        self._map()
        self.power_on()

    def power_on(self) -> None:
        """Load the image and start it as after a reset."""
        address, size = self._board.ram
        self._uc.mem_write(address, b"\xa5" * size)
        first, size = self._board.flash
        for address, content in self._elf.segments:
            if not first <= address <= address + len(content) <= first + size:
                raise InputError(f"the image is not for {self._board.name}: it begins at {address:#010x}")
            self._uc.mem_write(address, content)
        self._uc.ctl_flush_tb()  # otherwise the translation of the previous program would run on
        stack, start = struct.unpack("<2I", bytes(self._uc.mem_read(self._board.flash[0], 8)))
        self._uc.reg_write(arm_const.UC_ARM_REG_SP, stack)
        self._pc = start
        self._to_board.clear()
        self._reboot = False
        self.watchdog = None
        self.registers.clear()
        self.run()

    def write(self, data: bytes) -> None:
        """Send bytes on the line to the board."""
        self._to_board.extend(data)

    def read(self) -> bytes:
        """Run until the board sleeps, and return the bytes that it sent."""
        self.run()
        data = bytes(self._from_board)
        self._from_board.clear()
        return data

    def run(self) -> None:
        """Run until the board sleeps with an empty line, or hangs without reading."""
        while True:
            waiting = len(self._to_board)
            try:
                self._uc.emu_start(self._pc | 1, _NOWHERE)
            except unicorn.UcError as error:
                at = self._uc.reg_read(arm_const.UC_ARM_REG_PC)
                raise LinkError(f"the program stopped at {at:#010x}: {error}") from error
            self._pc = self._uc.reg_read(arm_const.UC_ARM_REG_PC)
            if self._reboot:
                self.power_on()
                return
            if not self._to_board or len(self._to_board) == waiting:
                return

    def advance(self, ms: float) -> None:
        """Advance the simulated time."""
        while ms > 0:
            step = min(ms, _STEP_MS)
            before = self._ticks
            self._ticks += round(step * self._board.hertz / 1000)
            period = self._reload + 1
            self._wrapped |= before // period != self._ticks // period
            self.run()
            if self._hung():
                self.power_on()
            ms -= step

    def reload_watchdog(self) -> None:
        """Restart the independent watchdog's count."""
        self.watchdog = self._ticks

    def pulses(self) -> tuple[int, ...]:
        """Return the pulse widths of the output timer in ticks."""
        return tuple(self.registers.get(at, 0) for at in _TIM3_CCR)

    def _hung(self) -> bool:
        if self.watchdog is None:
            return False
        count = (self.registers.get(_IWDG_RLR, 0xFFF) + 1) * (4 << self.registers.get(_IWDG_PR, 0))
        return self._ticks - self.watchdog > count / _IWDG_HERTZ * self._board.hertz

    def memory(self, symbol: str) -> bytes:
        """Return the bytes of a variable."""
        address, size = self._elf.symbols[symbol]
        return bytes(self._uc.mem_read(address, size))

    def on_range(self, first: int, last: int, hook: Hook) -> None:
        """Call `hook` for each block of instructions that starts in a range of addresses."""

        def called(_uc: Any, address: int, size: int, _data: Any) -> None:
            hook(address, size)

        self._hooks.append(self._uc.hook_add(unicorn.UC_HOOK_BLOCK, called, begin=first, end=last))
        self._uc.ctl_flush_tb()

    def on_instruction(self, address: int, hook: Callable[[], None]) -> None:
        """Call `hook` before an instruction runs."""

        def called(_uc: Any, _address: int, _size: int, _data: Any) -> None:
            hook()

        self._hooks.append(self._uc.hook_add(unicorn.UC_HOOK_CODE, called, begin=address, end=address))
        self._uc.ctl_flush_tb()

    def flags(self) -> int:
        """Return the processor's status register, whose highest bits are N, Z, C and V."""
        return int(self._uc.reg_read(arm_const.UC_ARM_REG_CPSR))

    def register(self, name: str) -> int:
        """Return the value of a register."""
        return int(self._uc.reg_read(getattr(arm_const, f"UC_ARM_REG_{name.upper()}")))

    def unhook(self) -> None:
        """Remove every hook."""
        for handle in self._hooks:
            self._uc.hook_del(handle)
        self._hooks.clear()
        self._uc.ctl_flush_tb()

    def link_register(self) -> int:
        """Return the return address of the current function."""
        return int(self._uc.reg_read(arm_const.UC_ARM_REG_LR)) & ~1

    def _map(self) -> None:
        """Map flash, RAM and registers; other addresses stay unmapped, so that access to them fails."""
        for address, size in (self._board.flash, self._board.ram):
            self._uc.mem_map(address, size)
        # exception returns of the M-profile and other addresses that never execute code stay unmapped
        reads, writes = _REGISTERS[self._board.source]
        self._uc.mmio_map(
            *_PERIPHERALS,
            lambda _u, at, _n, _d: reads(self, at),
            None,
            lambda _u, at, _n, v, _d: writes(self, at, v),
            None,
        )
        self._uc.mem_map(*_DEBUG)
        self._uc.mmio_map(
            *_SYSTEM, lambda _u, at, _n, _d: self._read_system(at), None,
            lambda _u, at, _n, v, _d: self._write_system(at, v), None,
        )  # fmt: skip

    def _read_system(self, offset: int) -> int:
        if offset == _SYST_CVR:
            return self._reload - self._ticks % (self._reload + 1)
        if offset == _SYST_CSR:
            wrapped, self._wrapped = self._wrapped, False
            return 7 | wrapped << 16
        return 0

    def _write_system(self, offset: int, value: int) -> None:
        if offset == _SYST_RVR:
            self._reload = value
        elif offset == _SYST_CVR:
            self._ticks = 0
        elif offset == _AIRCR and value == _RESET_KEY:
            self._reboot = True
            self._uc.emu_stop()

    def receive(self) -> int:
        """Return the next byte of the serial line, which must hold one."""
        return self._to_board.popleft()

    def waiting(self) -> bool:
        """Return True if a byte for the board is on the line."""
        return bool(self._to_board)

    def send(self, byte: int) -> None:
        """Accept a byte that the board sends."""
        self._from_board.append(byte & 0xFF)


def _read_stm32(machine: EmulatedBoard, at: int) -> int:
    """Return the value of a register: clocks are ready at once, and the line is always ready to send."""
    if at == _RCC_CR:
        value = machine.clock_control[at]
        return value | (value & _PLL_ON) << 1
    if at == _RCC_CFGR:
        value = machine.clock_control[at]
        return value | (value & 3) << 2
    if at in (0x11000, 0x4400):
        return 0xC0 | machine.waiting() << 5
    if at in (0x11004, 0x4404):
        return machine.receive()
    return 0


def _write_stm32(machine: EmulatedBoard, at: int, value: int) -> None:
    if at in machine.clock_control:
        machine.clock_control[at] = value
    if at == _IWDG_KR and (value == _IWDG_START or (value == _IWDG_RELOAD and machine.watchdog is not None)):
        machine.reload_watchdog()
    machine.registers[at] = value
    if at in (0x11004, 0x4404):
        machine.send(value)


def _read_mps2(machine: EmulatedBoard, at: int) -> int:
    if at == 0x4004:
        return machine.waiting() << 1
    return machine.receive() if at == 0x4000 else 0


def _write_mps2(machine: EmulatedBoard, at: int, value: int) -> None:
    if at == 0x4000:
        machine.send(value)


_REGISTERS = {"stm32f4.c": (_read_stm32, _write_stm32), "mps2.c": (_read_mps2, _write_mps2)}
