# SPDX-License-Identifier: Apache-2.0
"""The cache: an entry is whole or absent, whatever happens while it is made."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from mehvar.base import cache
from mehvar.base.errors import BuildError, InputError


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


def test_a_cache_has_the_folders_above_it_made(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MEHVAR_CACHE", str(root / "not" / "there"))
    assert cache.cache_folder() == root / "not" / "there"


def test_a_process_without_a_cache_keeps_one_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("MEHVAR_CACHE")
    monkeypatch.setattr(cache, "_roots", list)
    assert cache.cache_folder() == cache.cache_folder()


def test_an_entry_is_made_once() -> None:
    assert cache.find("kind", "name") is None
    folder = cache.entry("kind", "name", write)
    assert text(folder) == "whole"
    assert cache.entry("kind", "name", refuse) == cache.find("kind", "name") == folder


@pytest.mark.parametrize("damage", ["changed", "removed", "added", "without digests"])
def test_a_damaged_entry_is_made_again(damage: str) -> None:
    folder = cache.entry("kind", "name", write)
    if damage == "changed":
        (folder / "inner" / "text").write_text("hole")
    elif damage == "removed":
        (folder / "inner" / "text").unlink()
    elif damage == "without digests":
        (folder / ".sha256").unlink()
    else:
        (folder / "more").write_text("")
    assert cache.find("kind", "name") is None
    assert text(cache.entry("kind", "name", write)) == "whole"
    assert sorted(path.name for path in folder.iterdir()) == [".sha256", "inner"]


@pytest.mark.parametrize("name", ["inner/text", ".sha256"])
def test_a_file_that_others_can_write_is_made_again(name: str) -> None:
    folder = cache.entry("kind", "name", write)
    (folder / name).chmod(0o666)
    assert cache.find("kind", "name") is None
    assert text(cache.entry("kind", "name", write)) == "whole"
    assert (folder / name).stat().st_mode & 0o022 == 0


def test_a_wide_umask_opens_nothing() -> None:
    before = os.umask(0)
    try:
        folder = cache.entry("kind", "name", write)
    finally:
        os.umask(before)
    assert not [path for path in folder.rglob("*") if path.stat().st_mode & 0o022]
    assert cache.entry("kind", "name", refuse) == folder


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

    with pytest.raises(BuildError, match="disappeared 3 times while name was written"):
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
        "from mehvar.base import cache\n"
        "for k in range(60): cache.entry('kind', str(k), lambda f: (f / 'text').write_text('whole' * 1000))"
    )
    processes = [subprocess.Popen([sys.executable, "-c", code]) for _ in range(3)]
    assert [process.wait(120) for process in processes] == [0, 0, 0]
    assert all(cache.find("kind", str(k)) for k in range(60))


def test_a_key_tells_where_a_part_ends() -> None:
    assert cache.key("ab", "c") != cache.key("a", "bc")
    assert len(cache.key()) == 32


@pytest.mark.parametrize("mode", [0o777, 0o770, 0o757, 0o1777])
def test_a_cache_that_others_can_write_is_refused(root: Path, mode: int) -> None:
    """Else their library would be loaded as ours."""
    cache.entry("kind", "name", write)
    root.chmod(mode)
    try:
        assert cache.find("kind", "name") is None
        with pytest.raises(InputError, match=rf"\$MEHVAR_CACHE must be .*only you can write to: .*chmod go-w {root}"):
            cache.entry("kind", "name", write)
    finally:
        root.chmod(0o700)


def test_a_cache_of_another_user_is_refused(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cache.entry("kind", "name", write)
    monkeypatch.setattr("os.getuid", lambda: root.stat().st_uid + 1)
    assert cache.find("kind", "name") is None
    with pytest.raises(InputError, match="it belongs to the user with the number"):
        cache.cache_folder()


@pytest.mark.parametrize("inside", ["kind", "kind/name"])
def test_a_folder_in_the_cache_that_others_can_write_is_not_believed(root: Path, inside: str) -> None:
    cache.entry("kind", "name", write)
    (root / inside).chmod(0o777)
    assert cache.find("kind", "name") is None
    if inside == "kind":
        with pytest.raises(InputError, match=r"cannot be used: .*chmod go-w"):
            cache.entry("kind", "name", write)
    else:
        assert cache.is_private(cache.entry("kind", "name", write)), "it is made again"


@pytest.mark.parametrize("planted", ["mehvar-{uid}", "mehvar"])
def test_no_cache_has_a_name_that_others_can_guess(tmp_path: Path, planted: str) -> None:
    """Without a home another user's folder in the shared temporary one is never looked into."""
    trap = tmp_path / planted.format(uid=os.getuid())
    trap.mkdir()
    code = (
        "import pathlib, sys; from mehvar.base import cache\n"
        "def homeless(): raise RuntimeError\n"
        "pathlib.Path.home = homeless\n"
        "first = cache.entry('kind', 'name', lambda f: (f / 'text').write_text('whole'))\n"
        "assert first == cache.find('kind', 'name'), 'it serves this process'\n"
        "print(cache.cache_folder(), oct(cache.cache_folder().stat().st_mode & 0o777))"
    )
    names = ("MEHVAR_CACHE", "XDG_CACHE_HOME", "HOME")
    environment = {name: value for name, value in os.environ.items() if name not in names}
    command = [sys.executable, "-c", code]
    places = set()
    for _ in range(2):
        done = subprocess.run(
            command, env={**environment, "TMPDIR": str(tmp_path)}, capture_output=True, text=True, check=True
        )
        place, mode = done.stdout.split()
        assert mode == "0o700"
        places.add(place)
        assert not Path(place).exists(), "it ends with its process"
    assert len(places) == 2
    assert list(trap.iterdir()) == []


def test_a_home_that_others_can_write_is_passed_over(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("MEHVAR_CACHE")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    (tmp_path / "mehvar").mkdir()
    (tmp_path / "mehvar").chmod(0o777)
    assert cache.cache_folder() != tmp_path / "mehvar"
    assert cache.is_private(cache.cache_folder())
