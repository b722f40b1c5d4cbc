# SPDX-License-Identifier: Apache-2.0
"""Files that are whole or as they were, and folders that are refused before the work."""

from __future__ import annotations

import contextlib
from pathlib import Path

import pytest

from mehvar.base.errors import InputError
from mehvar.runtime.files import check_file, check_folder, filling, replacing, write_atomic


def test_a_folder_that_can_be_made_is_taken_and_one_below_a_file_is_not(tmp_path: Path) -> None:
    check_folder(tmp_path)
    check_folder(tmp_path / "new" / "below")
    assert list(tmp_path.iterdir()) == []
    (tmp_path / "file").write_text("")
    for place in ("file", "file/below"):
        with pytest.raises(InputError, match="file is a file"):
            check_folder(tmp_path / place)


def test_a_folder_that_may_not_be_written_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Root may write everywhere, so the system's answer is the one that other users get."""
    monkeypatch.setattr("os.access", lambda *_: False)
    with pytest.raises(InputError, match="you may not write into"):
        check_folder(tmp_path / "new")
    with pytest.raises(InputError, match="a file in a folder that can be written"):
        check_file(tmp_path / "new")


def test_a_file_is_taken_in_a_folder_that_exists(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    check_file(tmp_path / "new")
    with pytest.raises(InputError, match="in a folder that exists"):
        check_file(tmp_path / "none" / "new")
    with pytest.raises(InputError, match="a file in a folder that can be written"):
        check_file(tmp_path)
    monkeypatch.chdir(tmp_path)
    check_file("new")


def test_what_fails_leaves_the_old_file_and_nothing_else(tmp_path: Path) -> None:
    place = tmp_path / "file"
    write_atomic(place, "old")
    with contextlib.suppress(KeyError), replacing(place) as temporary:
        assert temporary.parent == tmp_path
        temporary.write_text("half")
        raise KeyError
    assert [path.read_text() for path in tmp_path.iterdir()] == ["old"]
    write_atomic(place, b"new")
    assert [path.read_text() for path in tmp_path.iterdir()] == ["new"]


@pytest.mark.parametrize(("place", "message"), [("none/file", "does not exist"), (".", "it is a folder")])
def test_what_is_no_place_for_a_file_is_refused(tmp_path: Path, place: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        write_atomic(tmp_path / place, "")


def test_an_error_of_the_system_names_the_file_and_not_its_temporary_name(tmp_path: Path) -> None:
    with pytest.raises(OSError, match=f"cannot write {tmp_path / 'file'}: No space left"), replacing(tmp_path / "file"):
        raise OSError(28, "No space left")
    with (
        pytest.raises(OSError, match=f"cannot write {tmp_path / 'out'}: No space left"),
        filling(tmp_path / "out", "maker"),
    ):
        raise OSError(28, "No space left")
    assert list(tmp_path.iterdir()) == []


def test_a_folder_is_filled_whole_beside_what_it_holds(tmp_path: Path) -> None:
    out = tmp_path / "a" / "b"
    for text in ("one", "two"):
        with filling(out, "maker") as scratch:
            (scratch / "inner").mkdir()
            (scratch / "inner" / "file").write_text(text)
            assert not list(out.rglob("file")) or text == "two"
        (out / "mine").write_text("")
    with contextlib.suppress(KeyError), filling(out, "maker") as scratch:
        (scratch / "inner").mkdir()
        raise KeyError
    assert sorted(path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*")) == [
        "a", "a/b", "a/b/.mehvar", "a/b/inner", "a/b/inner/file", "a/b/mine",
    ]  # fmt: skip
    assert (out / "inner" / "file").read_text() == "two"
