# SPDX-License-Identifier: Apache-2.0
"""The host reads all bytes that the firmware sends, and the other way round."""

from __future__ import annotations

import ctypes
from pathlib import Path

import numpy as np
import pytest

from mehvar.runtime.board.image.build import program, sources
from mehvar.runtime.board.line.frames import Decoder, Frame, crc32c, encode
from mehvar.runtime.compiling.library import load_library
from tests.runtime.board.conftest import load

BLOCK = 254
"""Bytes that are not zero in the longest block of the stuffing."""


@pytest.fixture(scope="module")
def firmware():
    texts = sources(program(load("satellite"), "mrac-literal"), None)  # the law with the longest memory
    texts["frames.c"] = (Path(__file__).parent / "frames.c").read_text()
    return load_library("board_frames", texts, ["link.c", "frames.c"], ("-O1", "-I.", "-DMEHVAR_FLOAT"))


def payloads(longest):
    """Payloads with zeros about the ends of blocks, and random ones of every size."""
    rng = np.random.default_rng(2)
    for size in range(longest + 1):
        plain = rng.integers(1, 256, size, dtype=np.uint8)
        yield plain.tobytes()
        for _ in range(3):
            holes = plain.copy()
            holes[rng.integers(0, size, rng.integers(1, 4)) if size else []] = 0
            yield holes.tobytes()
    header = 8
    for end in range(BLOCK - header - 3, longest + 1):
        for zero in range(max(0, end - 4), end):
            edge = rng.integers(1, 256, end, dtype=np.uint8)
            edge[zero] = 0
            yield edge.tobytes()


def pointer(data):
    return (ctypes.c_uint8 * len(data)).from_buffer(bytearray(data))


def test_every_frame_arrives_in_both_directions(firmware):
    longest = firmware.largest_payload()
    assert longest > BLOCK + 4
    for number, payload in enumerate(payloads(longest)):
        frame = Frame(3 + number % 2 * 0x80, number % 256, number * 7 % 0x10000, number * 0x10001 % 2**32, payload)
        line = (ctypes.c_uint8 * (2 * longest + 64))()
        body = bytes([frame.type, frame.flags]) + frame.session.to_bytes(2, "little")
        body += frame.number.to_bytes(4, "little") + payload
        count = firmware.send_frame(pointer(body), ctypes.c_long(len(payload)), line)
        decoder = Decoder()
        assert list(decoder.feed(bytes(line[:count]))) == [frame], f"{len(payload)} bytes, frame {number}"
        data = encode(frame)
        assert firmware.receive_bytes(pointer(data), ctypes.c_long(len(data)), line) == len(payload)
        assert bytes(line[: len(body)]) == body


def test_the_check_is_crc_32c():
    """The examples of RFC 3720, B.4."""
    assert crc32c(bytes(32)) == 0x8A9136AA
    assert crc32c(b"\xff" * 32) == 0x62A8AB43
    assert crc32c(bytes(range(32))) == 0x46DD794E


def test_what_is_damaged_is_counted_and_noise_for_ever_is_forgotten():
    decoder = Decoder()
    whole = encode(Frame(1, 0, 2, 3, b"payload"))
    broken = whole[:4] + bytes([whole[4] ^ 1]) + whole[5:]
    assert [frame.payload for frame in decoder.feed(broken + whole)] == [b"payload"]
    assert decoder.damaged == 1
    assert not list(decoder.feed(b"\1" * 200_000))
    assert len(decoder._rest) == 1 << 16
    assert [frame.payload for frame in decoder.feed(whole)] == [b"payload"]
    assert decoder.damaged == 2
