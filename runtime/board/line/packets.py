# SPDX-License-Identifier: Apache-2.0
"""The paper's bare packets, unframed numbers in both directions; see firmware/raw.c."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

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
