# SPDX-License-Identifier: Apache-2.0
"""Registers of the emulated boards, at the addresses that the makers' manuals give."""

from __future__ import annotations

import pytest

from mehvar.runtime.board.emulator.machine import _REGISTERS, EmulatedBoard
from mehvar.runtime.board.image.elf import Elf
from mehvar.runtime.board.image.toolchains import board


class Quiet(EmulatedBoard):
    """A board whose program never runs."""

    def run(self) -> None:
        """Stay where it is."""


def quiet(name: str) -> Quiet:
    chosen = board(name)
    stack, start = chosen.ram[0] + 0x800, chosen.flash[0] + 9
    image = stack.to_bytes(4, "little") + start.to_bytes(4, "little") + b"\xfe\xe7"
    return Quiet(Elf(((chosen.flash[0], image),), {}, len(image), 0, 0), chosen)


@pytest.mark.parametrize("usart", [0x11000, 0x4400])
def test_either_line_of_an_stm32_takes_and_gives_bytes(usart: int) -> None:
    """RM0090, USART: the state, whose bits 5, 6 and 7 are received, all sent and free, then the data."""
    (read, write), machine = _REGISTERS["stm32f4.c"], quiet("stm32f4")
    assert read(machine, usart) == 0xC0
    machine.write(b"\x07\x80")
    for byte in (0x07, 0x80):
        assert read(machine, usart) == 0xE0
        assert read(machine, usart + 4) == byte
    assert read(machine, usart) == 0xC0
    for byte in (0x00, 0xFF, 0x142):
        write(machine, usart + 4, byte)
    write(machine, usart + 8, 0x55)
    assert machine.read() == b"\x00\xff\x42"


def test_the_line_of_an_mps2_takes_and_gives_bytes() -> None:
    """AN385, the UART of CMSDK: the data, then the state, whose bit 1 is received."""
    (read, write), machine = _REGISTERS["mps2.c"], quiet("mps2-m3")
    machine.write(b"\x07")
    assert [read(machine, at) for at in (0x4004, 0x4000, 0x4004, 0x4008)] == [2, 7, 0, 0]
    write(machine, 0x4000, 0x21)
    write(machine, 0x4004, 0x22)
    assert machine.read() == b"\x21"


def test_the_clocks_of_an_stm32_say_that_they_are_ready() -> None:
    """RM0090, RCC: bit 25 follows 24, and two bits above the two that choose the clock."""
    (read, write), machine = _REGISTERS["stm32f4.c"], quiet("stm32f4")
    assert read(machine, 0x23800) == 0x83
    write(machine, 0x23800, 0x83 | 1 << 24)
    assert read(machine, 0x23800) == 0x83 | 3 << 24
    for choice in (0, 2):
        write(machine, 0x23808, choice)
        assert read(machine, 0x23808) == choice | choice << 2
    assert read(machine, 0x23C00) == 0


def test_pulses_are_those_of_the_timers_registers() -> None:
    """RM0090, timers: TIM3 is at 0x40000400, and its four widths from 0x34 on."""
    (_, write), machine = _REGISTERS["stm32f4.c"], quiet("stm32f4")
    for k in range(4):
        write(machine, 0x434 + 4 * k, 100 + k)
    assert machine.pulses() == (100, 101, 102)


@pytest.mark.parametrize(("prescaler", "reload"), [(0, 0xFFF), (2, 99)])
def test_the_watchdog_of_an_stm32_bites_after_its_count_and_only_once_started(prescaler: int, reload: int) -> None:
    """RM0090, IWDG: the count is from the reload down to zero, at 32 kHz over 4 times 2 to the prescaler."""
    (_, write), machine = _REGISTERS["stm32f4.c"], quiet("stm32f4")
    write(machine, 0x3000, 0xAAAA)
    assert machine.watchdog is None
    write(machine, 0x3004, prescaler)
    write(machine, 0x3008, reload)
    write(machine, 0x3000, 0xCCCC)
    ms = (reload + 1) * (4 << prescaler) / 32
    for _ in range(3):
        machine.advance(0.9 * ms)
        assert machine.watchdog is not None
        write(machine, 0x3000, 0xAAAA)
    machine.advance(1.05 * ms + 20)
    assert machine.watchdog is None


def test_the_ticks_of_a_cortex_m_count_down_from_what_the_program_wrote() -> None:
    """ARMv7-M, SysTick: 0x14 is the reload, 0x18 the count; bit 16 of 0x10 says once that it passed zero."""
    machine = quiet("stm32f4")
    machine._write_system(0x14, 999)
    machine._write_system(0x18, 5)
    assert machine._read_system(0x18) == 999
    machine.advance(1.0)
    assert machine._read_system(0x18) == 999 - round(machine._board.hertz / 1000) % 1000
    assert [machine._read_system(0x10) for _ in range(2)] == [7 | 1 << 16, 7]
