# SPDX-License-Identifier: Apache-2.0
"""Frames as in firmware/mehvar/private/link.h: COBS, CRC-16, sequence number."""

from __future__ import annotations

import binascii
import struct
from collections.abc import Iterator
from dataclasses import dataclass

_HEADER = struct.Struct("<BBH")
_LONGEST = 1 << 16
"""Bytes without a delimiter that are kept: above any frame, and a bound for a line that sends noise for ever."""


@dataclass(frozen=True)
class Frame:
    """What is between two delimiters, checked."""

    type: int
    flags: int
    sequence: int
    payload: bytes


def encode(frame: Frame) -> bytes:
    """Return a frame as it goes on the line, with a delimiter at each end."""
    body = _HEADER.pack(frame.type, frame.flags, frame.sequence) + frame.payload
    body += binascii.crc_hqx(body, 0xFFFF).to_bytes(2, "little")
    return b"\0" + _stuff(body) + b"\0"


class Decoder:
    """Finds whole frames in a stream of bytes.

    Attributes
    ----------
    damaged : int
        Frames that were thrown away.
    """

    def __init__(self) -> None:
        self.damaged = 0
        self._rest = b""

    def feed(self, data: bytes) -> Iterator[Frame]:
        """Take bytes and give the frames that they complete."""
        *whole, rest = (self._rest + data).split(b"\0")
        self._rest = rest[-_LONGEST:]
        for stuffed in filter(None, whole):
            frame = _decode(stuffed)
            if frame is None:
                self.damaged += 1
            else:
                yield frame


def _decode(stuffed: bytes) -> Frame | None:
    body = _unstuff(stuffed)
    if body is None or len(body) < _HEADER.size + 2:
        return None
    content, crc = body[:-2], int.from_bytes(body[-2:], "little")
    if binascii.crc_hqx(content, 0xFFFF) != crc:
        return None
    kind, flags, sequence = _HEADER.unpack_from(content)
    return Frame(kind, flags, sequence, content[_HEADER.size :])


def _stuff(body: bytes) -> bytes:
    """Replace zeros by the distance to the next one (consistent overhead byte stuffing)."""
    stuffed = bytearray()
    for block in body.split(b"\0"):
        while len(block) >= 254:  # the longest block that one code byte, 1 to 255, can announce
            stuffed += b"\xff" + block[:254]
            block = block[254:]
        stuffed.append(len(block) + 1)
        stuffed += block
    return bytes(stuffed)


def _unstuff(stuffed: bytes) -> bytes | None:
    body, at = bytearray(), 0
    while at < len(stuffed):
        code = stuffed[at]
        if at + code > len(stuffed):
            return None
        body += stuffed[at + 1 : at + code]
        at += code
        if code != 0xFF and at < len(stuffed):
            body.append(0)
    return bytes(body)
