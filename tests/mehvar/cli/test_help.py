# SPDX-License-Identifier: Apache-2.0
"""`-h` of every command, and pages of 80 columns; in this process."""

from __future__ import annotations

import sys

import pytest

from mehvar import __main__
from mehvar.cli import doctor
from mehvar.cli.app import BOARD, COMMANDS, EXPORT
from mehvar.runtime.model.catalogue import find_model, list_models

EVERY = [(), *((name,) for name in COMMANDS), *(("board", name) for name in BOARD), *(("export", n) for n in EXPORT)]


def printed(monkeypatch, capsys, *words: str) -> str:
    monkeypatch.setattr(sys, "argv", ["mehvar", *words])
    with pytest.raises(SystemExit) as end:
        __main__._run()
    assert not end.value.code
    return capsys.readouterr().out


@pytest.mark.parametrize("words", EVERY, ids=" ".join)
def test_h_is_help(words, monkeypatch, capsys):
    short, long = (printed(monkeypatch, capsys, *words, flag) for flag in ("-h", "--help"))
    assert short == long
    assert "-h, --help" in short


@pytest.mark.parametrize("name", BOARD)
def test_help_names_the_target_only_where_there_is_one(name, monkeypatch, capsys):
    page = " ".join(printed(monkeypatch, capsys, "board", name, "-h").split())
    assert "With --target sil also" not in page or "--target " in page.replace("With --target", "")


def test_doctor_says_what_works_and_what_to_install(monkeypatch, capsys):
    monkeypatch.setattr(doctor, "installed", lambda name: {} if name in ("jax", "numba") else {name: "1.0"})
    page = printed(monkeypatch, capsys, "doctor")
    works = page.partition("works: ")[2].partition("\n")[0]
    assert "every run" in works
    assert "right-hand sides in JAX" not in works
    assert 'for the rest: pip install "mehvar[jax,numba]"' in page


@pytest.mark.parametrize("model", list_models())
def test_show_fits_a_page_and_shows_what_people_call(model, monkeypatch, capsys):
    page = printed(monkeypatch, capsys, "show", model)
    assert max(map(len, page.splitlines())) <= 80
    for name, function in find_model(model).functions.items():
        assert (f"\n{name} " in page) is not function.internal
