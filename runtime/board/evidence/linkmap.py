# SPDX-License-Identifier: Apache-2.0
"""Map file of GNU ld for an image (`-Wl,-Map=FILE`): origins of addresses, library members."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from mehvar.base.errors import bad_value

_HEAD = "Linker script and memory map"
_PIECE = re.compile(r"^ (?:\.\S+|COMMON)\s+0x([0-9a-f]+)\s+0x([0-9a-f]+) (\S.*)$", re.MULTILINE)
_MEMBER = re.compile(r"^(\S+\(\S+\))\s+(\S.*?) \((\S+)\)$", re.MULTILINE)


@dataclass(frozen=True)
class Member:
    """Library member in the image, with the file and symbol that required it."""

    member: str
    file: str
    symbol: str


@dataclass(frozen=True)
class LinkMap:
    """Contents of a map file.

    Attributes
    ----------
    members : tuple of Member
        Members of libraries in the image.
    pieces : tuple of (int, int, str)
        Address, size and object file of each piece of the image.
    """

    members: tuple[Member, ...]
    pieces: tuple[tuple[int, int, str], ...]

    def origin(self, address: int) -> str | None:
        """Return the object file of an address."""
        return next((file for first, size, file in self.pieces if first <= address < first + size), None)


def read_map(path: Path) -> LinkMap:
    """Read a map file.

    Raises
    ------
    InputError
        If the file is not a map of GNU ld.
    """
    text = path.read_text(encoding="utf-8", errors="replace")
    before, head, after = text.partition(_HEAD)
    if not head:
        raise bad_value("map", str(path), "a map of GNU ld: -Wl,-Map=FILE", "--map")
    members = before.partition("Allocating common symbols")[0].partition("Discarded input sections")[0]
    pieces = ((int(m[1], 16), int(m[2], 16), m[3]) for m in _PIECE.finditer(after))
    return LinkMap(
        tuple(Member(m[1], m[2], m[3]) for m in _MEMBER.finditer(members)),
        tuple(piece for piece in pieces if piece[0] and piece[1]),
    )
