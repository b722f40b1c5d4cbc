# SPDX-License-Identifier: Apache-2.0
"""The paper's bare packets, unframed numbers in both directions; see firmware/raw.c."""

from __future__ import annotations

import ctypes

import numpy as np
from numpy.typing import NDArray

from mehvar.base.names import identifier

from ...model.functions import CBackend, Real
from ...model.parameters import Resolved
from ..image.build import Program
from ..image.header import raw_numbers
from .link import LinkError, Port

Doubles = NDArray[np.float64]
_FIRST_TRIES, _FIRST_TIMEOUT = 10, 0.5
"""Number of attempts and timeout of the first packet, five seconds for the start of a board. Later packets are not
repeated, because each is a new sample.
"""


class BareLaw:
    """A law on a board with bare packets; give it to `simulate` as `law`.

    The board has compiled-in parameters, and initialises its memory from the first packet.
    """

    def __init__(self, port: Port, program: Program, timeout: float = 2.0) -> None:
        self.u: list[NDArray[np.float32]] = []
        self._port, self._timeout = port, timeout
        self._packet = np.zeros(raw_numbers(program.layout), "<f4")
        self._memory, self._answer = bool(program.law.memory), 4 * len(program.layout.outputs)

    def __call__(self, x: Doubles, r: Doubles, v: Doubles, z: Doubles) -> tuple[Doubles, Doubles]:
        """Return the board's input for the next sample."""
        numbers = np.concatenate([x, r, v] if self._memory else [x, r])
        self._packet[: len(numbers)] = numbers
        # the line may open before the board listens
        for _ in range(1 if self.u else _FIRST_TRIES):
            self._port.write(self._packet.tobytes())
            data = self._received(_FIRST_TIMEOUT if not self.u else self._timeout)
            if data:
                break
        if len(data) != self._answer:
            raise LinkError(
                f"{self._port.name} answers {len(data)} bytes instead of {self._answer} to packet {len(self.u)}: "
                "does it run the image for the bare link?"
            )
        u = np.frombuffer(data, "<f4").astype(np.float32)
        self.u.append(u)
        return u.astype(np.float64), z

    def _received(self, timeout: float) -> bytes:
        data = b""
        while len(data) < self._answer and (more := self._port.read(timeout)):
            data += more
        return data


class HostLaw:
    """The law on this machine, with memory initialised as on the board.

    Parameters
    ----------
    real : {"float", "double"}
        Number type of the law.
    """

    def __init__(self, program: Program, resolved: Resolved, real: Real = "float") -> None:
        backend = program.model.evaluator
        assert isinstance(backend, CBackend)
        name = identifier(program.law.name)
        by_identifier = {identifier(f): f for f in program.model.manifest.functions}
        self.set(resolved)
        self._z: Doubles | None = None
        self._law = _function(backend.address(by_identifier[name], real), 8 if program.law.memory else 5)
        start = by_identifier.get(f"{name}_start")
        self._start = None if start is None else _function(backend.address(start, real), 5)
        self._nu, self.real, self._memory = len(program.layout.outputs), real, bool(program.law.memory)

    def __call__(self, x: Doubles, r: Doubles, v: Doubles, z: Doubles) -> tuple[Doubles, Doubles]:
        """Return the law's input for the next sample."""
        u = np.zeros(self._nu)
        if not self._memory:
            _call(self._law, x, r, self._p, self._c, u)
            return u, z
        if self._z is None:
            self._z = np.zeros_like(z)
            if self._start is not None:
                _call(self._start, x, r, self._p, self._c, self._z)
        following = np.zeros_like(z)
        _call(self._law, x, r, v, self._z, self._p, self._c, u, following)
        self._z = following
        return u, following

    def set(self, resolved: Resolved) -> None:
        """Change the law's parameters from the next sample on."""
        self._p, self._c = resolved.p, resolved.c

    def begin(self, z: Doubles) -> None:
        """Start from a given memory, as a board does when its host sets it."""
        self._z = z.astype(np.float32).astype(np.float64) if self.real == "float" else z


def _function(address: int, arguments: int) -> ctypes._CFunctionType:
    return ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * arguments)(address)


def _call(function: ctypes._CFunctionType, *arrays: Doubles) -> None:
    function(*(np.ascontiguousarray(a).ctypes.data for a in arrays))
