# SPDX-License-Identifier: Apache-2.0
"""Structures beside the default one: named where a change may reach them, compared where asked."""

import contextlib
import json
import re
import shutil

import pytest

import mehvar
from mehvar.codegen.structures import all_structures
from tests.mehvar.comparison.projects import Project

EDITS = {
    "STRUCTURE: dict[str, tuple[str, ...]] = {}": 'STRUCTURE = {"kind": ("linear", "firm"), "wall": ("none", "near")}',
    "def system() -> System:": 'def system(kind="linear", wall="none") -> System:',
    "structure={}": 'structure={"kind": kind, "wall": wall}',
    "Quantity, System": "ModelError, Quantity, System",
    "    d = Derivation()\n": """    if (kind, wall) == ("linear", "near"):
        raise ModelError("wall = 'near': needs 'firm'")
    force = -p.k * x - p.d * v
    if kind == "firm":
        force -= 3 * p.k * x
    if wall == "near":
        force += p.d * v / 2
    d = Derivation()
""",
    'd.define("spring", -p.k * x - p.d * v,': 'd.define("spring", force,',
}
"""The cart gets two choices, of which one value goes with another one only."""


@pytest.fixture(scope="module")
def structured(committed, tmp_path_factory):
    """The cart with choices, generated and committed."""
    root = tmp_path_factory.mktemp("structured") / "tree"
    shutil.copytree(committed, root)
    project = Project(root)
    for old, new in EDITS.items():
        project.edit(old, new)
    project.generate()
    project.commit("two choices")
    return root


@pytest.fixture
def project(structured, tmp_path):
    """A copy that a test may change."""
    shutil.copytree(structured, tmp_path / "tree")
    return Project(tmp_path / "tree")


@pytest.mark.soak
def test_a_change_that_other_structures_alone_show_is_undecided_until_they_are_compared(project):
    project.edit("force -= 3 * p.k", "force += 3 * p.k")
    result = project.json(status=1)
    assert result["status"] == "undecided"
    (note,) = result["notes"]
    assert "models/cart/__init__.py changed" in note
    compared = project.json("--structures", "all", status=1)
    assert compared["status"] == "same"
    first, *others = compared["structures"]
    assert (first["variant"], first["status"], others) == ("kind=firm", "changed", [])
    assert compared["notes"] == [
        "structures, changed by edits that are shown for another structure: kind=firm,wall=near"
    ]
    (edited,) = [e for e in first["equations"] if e["verdict"] == "changed"]
    assert [edit["says"] for edit in edited["edits"]] == ["-4 became 2"]
    text = project.diff("--structures", "all")[1]
    assert "cart kind=firm: physics CHANGED" in text


@pytest.mark.parametrize(
    ("linear", "firm"),
    [
        ("force = -2 * p.k * x - p.d * v", "force = -p.k * x - 2 * p.d * v"),  # a coefficient is doubled
        ("force = p.k * x - p.d * v", "force = -p.k * x + p.d * v"),  # a sign is flipped
    ],
)
@pytest.mark.share(2)
def test_two_edits_in_the_same_words_are_two(project, linear, firm):
    """Each structure has another term that was doubled, or turned its sign."""
    project.edit("force = -p.k * x - p.d * v", f'{linear}\n    if kind == "firm":\n        {firm}')
    result = project.json("--structures", "kind=firm", status=1)
    assert [part["variant"] for part in result["structures"]] == ["kind=firm"]
    assert not any("shown for another structure" in note for note in result["notes"])


def test_a_structure_that_is_named_is_compared_and_the_rest_stays_undecided(project):
    project.edit("p.d * v / 2", "p.d * v / 4")
    result = project.json("--structures", "kind=firm", status=1)
    assert (result["status"], result["structures"]) == ("undecided", [])
    assert "structures, the same: kind=firm" in result["notes"]
    with contextlib.chdir(project.root):
        found = mehvar.diff("cart", structures=["kind=firm,wall=near"])
    assert [(part.variant, part.status) for part in found.structures] == [("kind=firm,wall=near", "changed")]


def test_a_choice_that_the_model_refuses_alone_comes_with_what_it_needs(project):
    project.edit("p.d * v / 2", "p.d * v / 4")
    result = project.json("--structures", "wall=near", status=1)
    assert [part["variant"] for part in result["structures"]] == ["kind=firm,wall=near"]


@pytest.mark.soak
def test_all_structures_decide_that_a_rearrangement_is_none(project):
    project.edit("force -= 3 * p.k * x", "force = force - x * 3 * p.k")
    assert project.json(status=1)["status"] == "undecided"
    result = project.json("--structures", "all", status=0)
    assert (result["status"], result["structures"]) == ("same", [])
    assert "structures, the same: kind=firm; kind=firm,wall=near" in result["notes"]


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("    d = Derivation()\n", "    # of the motion\n    d = Derivation()\n"),
        ('"""A cart on a spring: ', '"""One cart on a spring: '),
        ("force -= 3 * p.k * x", "force -= (3 * p.k * x)"),
    ],
)
@pytest.mark.share(3)
def test_comments_layout_and_docstrings_reach_no_structure(project, old, new):
    project.edit(old, new)
    assert project.json(status=0)["notes"] == []


def test_a_table_that_other_structures_alone_read_is_named(project):
    (project.source.parent / "walls.toml").write_text("near = 1.0\n")
    project.generate()
    project.commit("a table")
    project.edit("1.0", "2.0", "models/cart/walls.toml")
    assert "models/cart/walls.toml changed" in project.json(status=1)["notes"][0]
    project.edit("near = 2.0", "near = 1.0 # m", "models/cart/walls.toml")
    assert project.json(status=0)["notes"] == []


def test_folders_alone_name_the_sources_that_differ(project, tmp_path):
    before = project.root / "generated" / "cart"
    before = before.rename(tmp_path / "before")
    project.edit("force -= 3 * p.k", "force += 3 * p.k")
    project.generate()
    after = (project.root / "generated" / "cart").rename(tmp_path / "after")
    assert "models/cart/__init__.py changed" in project.json(str(before), str(after), status=1)["notes"][0]
    refused = project.refused(str(before), str(after), "--structures", "all")
    assert re.search(r"before has no models/cart", refused)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("kind", "must be NAME=VALUE"),
        ("king=firm", "unknown structure 'king'"),
        ("kind=quartic", "must be one of linear, firm"),
    ],
)
def test_a_structure_that_does_not_exist_is_refused(project, text, message):
    assert message in project.refused("--structures", text)


def test_too_many_combinations_are_left_to_the_user_and_said():
    every, complete = all_structures({"a": ("0", "1"), "b": ("0", "1", "2")})
    assert (len(every), complete) == (5, True)
    every, complete = all_structures({"n": tuple(map(str, range(32))), "b": ("0", "1")})
    assert (len(every), complete) == (32, False)
    assert json.dumps({"b": "1"}) in map(json.dumps, every)
