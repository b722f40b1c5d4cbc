# SPDX-License-Identifier: Apache-2.0
"""A run as its scenario describes it is checked against the numbers that the scenario expects."""

from __future__ import annotations

import json
import shutil

import pytest

from tests.derived import generated
from tests.fuzz.campaign import in_process
from tests.manifests import write_manifest

NOTE = "the scenario paper expects T_theta = 1, not "


@pytest.fixture(scope="module")
def edited(tmp_path_factory: pytest.TempPathFactory) -> str:
    """The triangle with another expected time."""
    folder = tmp_path_factory.mktemp("expected") / "triangle"
    shutil.copytree(generated("triangle"), folder, ignore=shutil.ignore_patterns("__pycache__"))
    facts = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))
    facts["scenarios"]["paper"]["expect"]["path"]["T_theta"] = 1.0
    write_manifest(folder, facts)
    return str(folder)


def test_another_number_is_a_note_in_text_and_in_json(edited: str) -> None:
    line = ("simulate", edited, "--controller", "path")
    assert NOTE in in_process(*line)[1]
    facts = json.loads(in_process(*line, "--json")[1])
    assert [note for note in facts["notes"] if note.startswith(NOTE)]


def test_nothing_is_expected_of_other_settings_and_other_laws(edited: str) -> None:
    path = ("simulate", edited, "--controller", "path")
    others = (*path, "--set", "R=0.6"), (*path, "--t-end", "10"), (*path, "--scenario", "paper-b")
    for line in (*others, (*path[:-1], "sliding"), ("simulate", "triangle", *path[2:])):
        status, text = in_process(*line)
        assert (status, "expects" in text) == (0, False), text
