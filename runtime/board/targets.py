# SPDX-License-Identifier: Apache-2.0
"""Lines to boards: process, Unicorn, QEMU, serial port."""

from __future__ import annotations

import errno
import os
import queue
import shutil
import subprocess
import tempfile
import threading
from pathlib import Path

from mehvar.base.errors import InputError, MissingError

from .image.build import Image
from .image.elf import read_elf
from .line.link import ClosedError, Port

TARGETS = ("sil", "unicorn", "qemu")
"""Targets without hardware; all other names are serial ports."""
_CHUNK = 4096
"""Number of bytes per read, above the length of any frame."""
_REASONS = {
    errno.ENOENT: "there is no such port",
    errno.EACCES: "no permission: on Linux join the group of the port, often dialout, and log in again",
    errno.EBUSY: "another program has it open",
    errno.ENOTTY: "it is not a serial port",
}
_LAST = 2.0
"""Seconds for a process to end before it is killed."""


class ProcessPort:
    """A process whose input and output are the line: the firmware itself, or an emulator.

    A thread reads its bytes, because Windows cannot read a pipe with a timeout.
    """

    def __init__(self, *command: str | Path, name: str = "") -> None:
        self.name = name or f"process {command[-1]}"
        self._messages = tempfile.TemporaryFile()  # noqa: SIM115 - open as long as the line
        pipe = subprocess.PIPE
        self._process = subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=self._messages)
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._to = self._process.stdin.fileno()
        self._incoming: queue.SimpleQueue[bytes] = queue.SimpleQueue()
        self._reader = threading.Thread(target=self._gather, args=(self._process.stdout.fileno(),), daemon=True)
        self._reader.start()

    def write(self, data: bytes) -> None:
        """Send bytes."""
        try:
            os.write(self._to, data)
        except OSError as error:
            raise self._ended() from error

    def read(self, timeout: float) -> bytes:
        """Return received bytes."""
        try:
            content = self._incoming.get(timeout=timeout)
        except queue.Empty:
            return b""
        if not content:
            self._incoming.put(content)  # for the next one who asks
            raise self._ended()
        return content

    def close(self) -> None:
        """End the process, by force if it does not stop within _LAST seconds."""
        self._process.terminate()
        self._reader.join(_LAST)  # before its pipe is closed: another file may get the pipe's number
        for pipe in (self._process.stdin, self._process.stdout, self._messages):
            pipe.close()  # type: ignore[union-attr]
        try:
            self._process.wait(_LAST)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()

    def _gather(self, pipe: int) -> None:
        while content := os.read(pipe, _CHUNK):
            self._incoming.put(content)
        self._incoming.put(b"")

    def _ended(self) -> ClosedError:
        self._messages.seek(0)
        text = " ".join(self._messages.read().decode(errors="replace").split())
        return ClosedError(f"{self.name} has ended{text and ': '}{text}")


class MachinePort:
    """A board under Unicorn, whose reads never wait."""

    def __init__(self, image: Image) -> None:
        try:
            from .emulator.machine import EmulatedBoard
        except ModuleNotFoundError as error:
            raise MissingError('the target unicorn needs its package: pip install "mehvar[board]"') from error
        assert image.board is not None
        self.name = f"unicorn {image.board.name}"
        self.machine = EmulatedBoard(read_elf(image.path), image.board)

    def write(self, data: bytes) -> None:
        """Send bytes."""
        self.machine.write(data)

    def read(self, timeout: float) -> bytes:  # noqa: ARG002 - emulated time stands still
        """Run the board until it sleeps, and return what it sent."""
        return self.machine.read()

    def close(self) -> None:
        """Do nothing, because a Unicorn machine needs no release."""


class SerialPort:
    """A serial port of pyserial: /dev/ttyUSB0, COM3, a pty, socket://host:port."""

    def __init__(self, name: str, baud: int = 115200) -> None:
        try:
            import serial
        except ModuleNotFoundError as error:
            raise MissingError(f'the port {name} needs pyserial: pip install "mehvar[board]"') from error
        self.name = name
        try:
            # two hosts on one port would take each other's answers; a URL is not a device that can be locked
            lock = {} if "://" in name or os.name == "nt" else {"exclusive": True}
            self._port = serial.serial_for_url(name, baudrate=baud, timeout=0, **lock)
        except (serial.SerialException, ValueError) as error:
            allowed = f"{', '.join(TARGETS)}, or a serial port that can be opened"
            reason = _REASONS.get(getattr(error, "errno", None) or 0, str(error))
            raise InputError(f"target = {name!r}: must be {allowed} ({reason})") from error

    def write(self, data: bytes) -> None:
        """Send bytes."""
        try:
            self._port.write(data)
        except OSError as error:
            raise ClosedError(f"{self.name} has closed: {error}") from error

    def read(self, timeout: float) -> bytes:
        """Return received bytes."""
        try:
            self._port.timeout = timeout
            first = self._port.read(1)
            return bytes(first + self._port.read(self._port.in_waiting)) if first else b""
        except OSError as error:
            raise ClosedError(f"{self.name} has closed: {error}") from error

    def close(self) -> None:
        """Close the port."""
        self._port.close()


def open_target(target: str, image: Image) -> Port:
    """Open the line to a board.

    Parameters
    ----------
    target : str
        "sil", "unicorn", "qemu" or the name of a serial port.
    image : Image
        Image for the emulators; a board at a serial port must already run it.

    Raises
    ------
    InputError
        If the emulator is not installed or the port cannot be opened.
    """
    if target == "sil":
        return ProcessPort(*image.toolchain.emulator, image.path)
    if target == "unicorn":
        return MachinePort(image)
    if target == "qemu":
        assert image.board is not None
        return ProcessPort(*qemu_command(image, "stdio"), name=f"qemu {image.board.machine}")
    return SerialPort(target)


def qemu_command(image: Image, line: str) -> list[str]:
    """Return the command that runs an image under QEMU, with the given serial line."""
    assert image.board is not None
    program = shutil.which("qemu-system-arm")
    if program is None:
        raise MissingError("the target qemu needs qemu-system-arm: apt-get install qemu-system-arm")
    quiet = ("-serial", "null") if image.board.defines.get("BOARD_USART") == 2 else ()
    return [
        program, "-M", image.board.machine, "-kernel", str(image.path), "-display", "none", "-monitor", "none",
        "-nodefaults", *quiet, "-serial", line,
    ]  # fmt: skip
