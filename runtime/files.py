# SPDX-License-Identifier: Apache-2.0
"""Files that are either complete or absent."""

from __future__ import annotations

import json
import os
import secrets
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from mehvar.base.errors import InputError, bad_value, either


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a temporary name beside `path`, renamed to `path` after a successful block.

    Parameters
    ----------
    path : path
        File to write; an old file stays unchanged until the new one is complete.

    Yields
    ------
    pathlib.Path
        Path for the block's output, removed if the block raises an error.

    Raises
    ------
    InputError
        If the folder of `path` does not exist, or `path` is a folder or a device.
    OSError
        If the file cannot be written; the message names `path`.
    """
    target = Path(path)
    if not target.parent.is_dir():
        raise InputError(f"cannot write {target}: the folder {target.parent} does not exist")
    if target.is_dir():
        raise InputError(f"cannot write {target}: it is a folder")
    if target.exists() and not target.is_file():
        raise InputError(f"cannot write {target}: it is a device, a pipe or a socket; choose another name")
    temporary = target.with_name(f".{target.name}.{os.getpid()}.{secrets.token_hex(4)}.tmp")
    try:
        yield temporary
        temporary.replace(target)
    except OSError as error:
        raise _named(error, target) from error
    finally:
        with suppress(OSError):
            temporary.unlink()


def check_folder(folder: str | os.PathLike[str], maker: str = "", names: Iterable[str] = ()) -> None:
    """Refuse an unwritable folder before the work starts.

    Parameters
    ----------
    folder : path
        Folder, created later if it does not exist.
    maker, names : str
        The command with its subject, as for `filling`, and the names that it writes.

    Raises
    ------
    InputError
        If it is not a folder, cannot be created or written, or has an entry of this name from another command.
    """
    target = Path(folder)
    there = next(place for place in (target, *target.absolute().parents) if place.exists())
    if not there.is_dir():
        raise bad_value("out", str(folder), f"a folder that can be made, but {there} is a file", "--out")
    if not os.access(there, os.W_OK):
        raise bad_value("out", str(folder), f"a folder that can be made, but you may not write into {there}", "--out")
    _check_maker(target, maker, names)


def _check_maker(folder: Path, maker: str, names: Iterable[str]) -> None:
    makers = _makers(folder)
    for name in names:
        if (folder / name).exists() and makers.get(name) != maker:
            whose = f"`{makers[name]}` made" if name in makers else f"`{maker}` did not make"
            raise bad_value("out", str(folder), f"another folder: this one has {name}, which {whose}", "--out")


def _makers(folder: Path) -> dict[str, str]:
    """Return the command behind each entry of a folder; empty if the record is unreadable."""
    with suppress(OSError, ValueError):
        record = json.loads((folder / _MAKERS).read_text(encoding="utf-8"))
        return {str(name): str(maker) for name, maker in record.items()} if isinstance(record, dict) else {}
    return {}


def check_file(path: str | os.PathLike[str]) -> None:
    """Refuse an unwritable file before the work starts.

    Raises
    ------
    InputError
        If its folder does not exist or cannot be written, or it is a folder itself.
    """
    # os.path, since pathlib raises for a name that is too long
    name, folder = os.fspath(path), os.path.dirname(os.fspath(path)) or os.curdir  # noqa: PTH120
    if not os.path.isdir(folder):  # noqa: PTH112
        raise bad_value("output file", name, "in a folder that exists")
    if os.path.isdir(name) or not os.access(folder, os.W_OK):  # noqa: PTH112
        raise bad_value("output file", name, "a file in a folder that can be written")


def checked_ending(field: str, path: str | os.PathLike[str], endings: Iterable[str], origin: str = "") -> str:
    """Return the ending of a file's name in lower case; refuse all but the given ones."""
    ending, known = Path(path).suffix.lower(), list(endings)
    if ending not in known:
        raise bad_value(field, os.fspath(path), f"a file name that ends in {either(known)}", origin)
    return ending


_MAKERS = ".mehvar"
"""File with the command that wrote each entry of a folder, which may replace the entry."""


@contextmanager
def filling(folder: str | os.PathLike[str], maker: str) -> Iterator[Path]:
    """Yield a temporary folder whose contents move into `folder` after a successful block.

    Parameters
    ----------
    folder : path
        Folder, created if necessary; its other contents stay.
    maker : str
        The command with its subject; entries of other commands and of the user are not replaced.

    Yields
    ------
    pathlib.Path
        Path for the block's output, removed if the block raises an error.

    Raises
    ------
    InputError
        If the folder has an entry of the same name that this command did not write.
    OSError
        If something cannot be written; the message names `folder`.
    """
    target = Path(folder).absolute()
    there = next(place for place in (target, *target.parents) if place.is_dir())
    try:
        with tempfile.TemporaryDirectory(prefix=f".{target.name}.", dir=there) as scratch:
            yield Path(scratch)
            names = sorted(path.name for path in Path(scratch).iterdir())
            _check_maker(Path(folder), maker, names)
            target.mkdir(parents=True, exist_ok=True)
            write_atomic(target / _MAKERS, json.dumps(_makers(target) | dict.fromkeys(names, maker), indent=1) + "\n")
            for path in sorted(Path(scratch).rglob("*")):
                place = target / path.relative_to(scratch)
                if path.is_dir():
                    place.mkdir(exist_ok=True)
                else:
                    path.replace(place)
    except OSError as error:
        raise _named(error, Path(folder)) from error


def write_atomic(path: str | os.PathLike[str], content: str | bytes) -> None:
    """Write a complete file; after a failure, the old one is unchanged.

    Parameters
    ----------
    path : path
        The file.
    content : str or bytes
        Content; text is written as UTF-8 with its own line ends.
    """
    with replacing(path) as temporary:
        temporary.write_bytes(content.encode() if isinstance(content, str) else content)


def _named(error: OSError, target: Path) -> OSError:
    reason = error.strerror or str(error)
    return OSError(error.errno or 0, f"cannot write {target}: {reason}")
