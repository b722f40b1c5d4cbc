# SPDX-License-Identifier: Apache-2.0
"""The cache: an entry is whole or absent, whatever happens while it is made."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from mehvar import cache
from mehvar.errors import BuildError


@pytest.fixture(autouse=True)
def root(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("MEHVAR_CACHE", str(tmp_path))
    return tmp_path


def write(folder: Path) -> None:
    (folder / "inner").mkdir()
    (folder / "inner" / "text").write_text("whole")


def text(folder: Path) -> str:
    return (folder / "inner" / "text").read_text()


def refuse(_: Path) -> None:
    pytest.fail("made again")


def test_an_entry_is_made_once() -> None:
    assert cache.find("kind", "name") is None
    folder = cache.entry("kind", "name", write)
    assert text(folder) == "whole"
    assert cache.entry("kind", "name", refuse) == cache.find("kind", "name") == folder


@pytest.mark.parametrize("damage", ["changed", "removed", "added"])
def test_a_damaged_entry_is_made_again(damage: str) -> None:
    folder = cache.entry("kind", "name", write)
    if damage == "changed":
        (folder / "inner" / "text").write_text("hole")
    elif damage == "removed":
        (folder / "inner" / "text").unlink()
    else:
        (folder / "more").write_text("")
    assert cache.find("kind", "name") is None
    assert text(cache.entry("kind", "name", write)) == "whole"
    assert sorted(path.name for path in folder.iterdir()) == [".sha256", "inner"]


def test_a_full_disk_leaves_nothing(root: Path) -> None:
    def fill(folder: Path) -> None:
        write(folder)
        raise OSError(28, "No space left on device")

    with pytest.raises(OSError, match="No space left"):
        cache.entry("kind", "name", fill)
    assert list((root / "kind").iterdir()) == []


def test_a_cache_that_is_emptied_again_and_again_is_an_error(root: Path) -> None:
    calls = []

    def fill(folder: Path) -> None:
        calls.append(folder)
        shutil.rmtree(root)

    with pytest.raises(BuildError, match="vanished each of 3 times that name was made"):
        cache.entry("kind", "name", fill)
    assert len(set(calls)) == 3


def test_who_is_second_takes_what_the_first_has_made() -> None:
    def fill(folder: Path) -> None:
        write(folder)
        cache.entry("kind", "name", write)

    folder = cache.entry("kind", "name", fill)
    assert text(folder) == "whole"
    assert [path.name for path in folder.parent.iterdir()] == ["name"]


def test_many_processes_at_once() -> None:
    code = (
        "from mehvar import cache\n"
        "for k in range(60): cache.entry('kind', str(k), lambda f: (f / 'text').write_text('whole' * 1000))"
    )
    processes = [subprocess.Popen([sys.executable, "-c", code]) for _ in range(3)]
    assert [process.wait(120) for process in processes] == [0, 0, 0]
    assert all(cache.find("kind", str(k)) for k in range(60))


def test_a_key_tells_where_a_part_ends() -> None:
    assert cache.key("ab", "c") != cache.key("a", "bc")
    assert len(cache.key()) == 32
