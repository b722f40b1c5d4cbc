# SPDX-License-Identifier: Apache-2.0
"""Frames as in firmware/mehvar/private/link.h: COBS, CRC-32C, session and request number."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass

_HEADER, _CRC = struct.Struct("<BBHI"), 4
_LONGEST = 1 << 16
"""Largest number of stored bytes without a delimiter, above the length of any frame, which limits memory under noise.
"""


@dataclass(frozen=True)
class Frame:
    """Checked contents between two delimiters."""

    type: int
    flags: int
    session: int
    number: int
    payload: bytes


def encode(frame: Frame) -> bytes:
    """Return the bytes of a frame on the line, with delimiters."""
    body = _HEADER.pack(frame.type, frame.flags, frame.session, frame.number) + frame.payload
    return b"\0" + _stuff(body + _check(body)) + b"\0"


class Decoder:
    """Finder of complete frames in a stream of bytes.

    Attributes
    ----------
    damaged : int
        Number of discarded frames.
    """

    def __init__(self) -> None:
        self.damaged = 0
        self._rest = b""

    def feed(self, data: bytes) -> Iterator[Frame]:
        """Add bytes and yield the frames that they complete."""
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
    if body is None or len(body) < _HEADER.size + _CRC:
        return None
    content = body[:-_CRC]
    if _check(content) != body[-_CRC:]:
        return None
    kind, flags, session, number = _HEADER.unpack_from(content)
    return Frame(kind, flags, session, number, content[_HEADER.size :])


def _check(content: bytes) -> bytes:
    """Return the CRC of header, payload and payload length."""
    size = (len(content) - _HEADER.size).to_bytes(4, "little")
    return crc32c(size + content).to_bytes(4, "little")


def crc32c(data: bytes) -> int:
    """Return the CRC-32C (Castagnoli) of bytes, as in RFC 3720, B.4."""
    crc = 0xFFFFFFFF
    for byte in data:
        crc = crc >> 8 ^ _TABLE[(crc ^ byte) & 0xFF]
    return crc ^ 0xFFFFFFFF


def _remainder(byte: int) -> int:
    for _ in range(8):
        byte = byte >> 1 ^ (0x82F63B78 if byte & 1 else 0)
    return byte


_TABLE = tuple(map(_remainder, range(256)))


def _stuff(body: bytes) -> bytes:
    """Replace zeros by the distance to the next zero (consistent-overhead byte stuffing)."""
    stuffed = bytearray()
    for block in body.split(b"\0"):
        while len(block) >= 254:  # the longest block that one code byte, 1 to 255, can announce
            stuffed += b"\xff" + block[:254]
            block = block[254:]
        stuffed.append(len(block) + 1)
        stuffed += block
    return bytes(stuffed)


def _unstuff(stuffed: bytes) -> bytes | None:
    """Return the bytes before COBS stuffing; None if they were damaged."""
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
