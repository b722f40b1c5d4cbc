# SPDX-License-Identifier: Apache-2.0
"""Lines to boards: process, Unicorn, QEMU, serial port."""

from __future__ import annotations

import errno
import os
import queue
import select
import shutil
import socket
import subprocess
import tempfile
import threading
import time
from collections.abc import Sequence
from pathlib import Path
from typing import IO

from mehvar.base.errors import InputError, MehvarError, MissingError

from .image.build import Image
from .image.elf import read_elf
from .line.link import LinkError, Port

TARGETS = ("sil", "unicorn", "qemu")
"""Targets without hardware; all other names are serial ports."""
_CHUNK = 4096
"""Number of bytes per read, above the length of any frame."""
_GATHER = 0.0005
"""Seconds to wait for the rest of an answer from QEMU, which arrives byte by byte. A shorter time splits reads; a
longer one delays every answer.
"""
_REASONS = {
    errno.ENOENT: "there is no such port",
    errno.EACCES: "no permission: on Linux join the group of the port, often dialout, and log in again",
    errno.EBUSY: "another program has it open",
    errno.ENOTTY: "it is not a serial port",
}
_LAST = 2.0
"""Seconds for a process to end before it is killed."""
_START_TRIES, _START_PAUSE = 1000, 0.01
"""Number of attempts and pauses until QEMU opens its line, ten seconds in total."""


class ProcessPort:
    """Software in the loop: the firmware as a process, emulated for another processor.

    A thread reads its bytes, because Windows cannot read a pipe with a timeout.
    """

    def __init__(self, path: Path, emulator: Sequence[str] = ()) -> None:
        self.name = f"process {path}"
        self._process = subprocess.Popen([*emulator, path], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._to = self._process.stdin.fileno()
        self._incoming: queue.SimpleQueue[bytes] = queue.SimpleQueue()
        self._reader = threading.Thread(target=self._gather, args=(self._process.stdout.fileno(),), daemon=True)
        self._reader.start()

    def write(self, data: bytes) -> None:
        """Send bytes."""
        os.write(self._to, data)

    def read(self, timeout: float) -> bytes:
        """Return received bytes, or none after the end of the process."""
        try:
            return self._incoming.get(timeout=timeout if self._reader.is_alive() else 0.0)
        except queue.Empty:
            return b""

    def close(self) -> None:
        """End the process."""
        self._process.terminate()
        self._reader.join(_LAST)  # before its pipe is closed: another file may get the pipe's number
        _end(self._process)

    def _gather(self, pipe: int) -> None:
        while content := os.read(pipe, _CHUNK):
            self._incoming.put(content)


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


class SocketPort:
    """A board under QEMU, with its serial line on a Unix socket."""

    def __init__(self, image: Image, options: tuple[str, ...] = ()) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="mehvar-qemu-")
        path, log = Path(self._folder.name) / "line", Path(self._folder.name) / "log"
        try:
            self.name, self._process = _qemu(image, f"unix:{path},server=on,wait=on", log, options)
            self._line = _connected(path, self._process, log)
        except MehvarError:
            self._folder.cleanup()
            raise

    def write(self, data: bytes) -> None:
        """Send bytes."""
        try:
            self._line.sendall(data)
        except OSError as error:
            raise LinkError(f"{self.name} closed the line") from error

    def read(self, timeout: float) -> bytes:
        """Return received bytes."""
        ready, _, _ = select.select([self._line], [], [], timeout)
        if not ready:
            return b""
        time.sleep(_GATHER)  # the emulator hands over bytes one at a time
        return self._line.recv(_CHUNK)

    def close(self) -> None:
        """End the emulator."""
        self._line.close()
        _end(self._process)
        self._folder.cleanup()


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
            raise LinkError(f"{self.name} has closed: {error}") from error

    def read(self, timeout: float) -> bytes:
        """Return received bytes."""
        try:
            self._port.timeout = timeout
            first = self._port.read(1)
            return bytes(first + self._port.read(self._port.in_waiting)) if first else b""
        except OSError as error:
            raise LinkError(f"{self.name} has closed: {error}") from error

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
        return ProcessPort(image.path, image.toolchain.emulator)
    if target == "unicorn":
        return MachinePort(image)
    if target == "qemu":
        return SocketPort(image)
    return SerialPort(target)


def _qemu(image: Image, line: str, log: Path, options: tuple[str, ...]) -> tuple[str, subprocess.Popen[bytes]]:
    """Start QEMU with the given serial line; its messages go to `log`."""
    assert image.board is not None
    program = shutil.which("qemu-system-arm")
    if program is None:
        raise MissingError("the target qemu needs qemu-system-arm: apt-get install qemu-system-arm")
    quiet = ("-serial", "null") if image.board.defines.get("BOARD_USART") == 2 else ()
    command = [
        program, "-M", image.board.machine, "-kernel", str(image.path), "-display", "none", "-monitor", "none",
        "-nodefaults", *quiet, "-serial", line, *options,
    ]  # fmt: skip
    with log.open("wb") as errors:
        process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=errors, stderr=errors)
    return f"qemu {image.board.machine}", process


def _connected(path: Path, process: subprocess.Popen[bytes], log: Path) -> socket.socket:
    """Return the socket of QEMU's serial port; end the process and refuse if it does not open in time."""
    line = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    for _ in range(_START_TRIES):
        try:
            line.connect(str(path))
            return line
        except OSError:
            if process.poll() is not None:
                break
            time.sleep(_START_PAUSE)
    line.close()
    _end(process)
    raise LinkError(f"qemu-system-arm did not start: {log.read_text(errors='replace').strip()}")


def _end(process: subprocess.Popen[bytes]) -> None:
    """Close the pipes of a process and end it, by force if it does not stop within _LAST seconds."""
    pipes: list[IO[bytes]] = [pipe for pipe in (process.stdin, process.stdout) if pipe]
    for pipe in pipes:
        pipe.close()
    process.terminate()
    try:
        process.wait(_LAST)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
