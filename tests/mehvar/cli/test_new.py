# SPDX-License-Identifier: Apache-2.0
"""`mehvar new`: the new system generates, simulates and passes its gates; a wrong term does not."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from mehvar.base.errors import InputError
from mehvar.cli.new import scaffold
from mehvar.codegen.generate import Tree, check
from tests import commands

ROOT = Path(__file__).parents[3]


def run(folder: Path, *command: str) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    start = commands.mehvar() if command[0] == "mehvar" else [sys.executable, "-m", command[0]]
    return subprocess.run(
        [*start, *command[1:]], cwd=folder, env=environment, capture_output=True, text=True, check=False
    )


@pytest.fixture(scope="module")
def project(tmp_path_factory):
    """A new system in a folder with a space and Persian letters, beside folders of the user's own."""
    place = tmp_path_factory.mktemp("my محور work")
    for name in ("models", "runtime", "codegen"):
        (place / name).mkdir()
        (place / name / "__init__.py").write_text("raise RuntimeError('the wrong package')\n")
    return scaffold("reaction_wheel", place)


def test_it_is_whole_and_up_to_date(project):
    assert sorted(p.name for p in project.iterdir()) == ["README.md", "generated", "models", "tests"]
    assert check(Tree(project), "reaction_wheel").reasons == ()
    assert list(project.parent.glob(".*")) == []


def test_its_own_tests_pass(project):
    done = run(project, "pytest", "-q", "-p", "no:cacheprovider", "tests")
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_commands_of_its_readme_work(project):
    assert run(project, "mehvar", "generate").stdout == "reaction_wheel: up to date\n"
    done = run(project, "mehvar", "simulate", "generated/reaction_wheel", "--controller", "balance")
    assert done.returncode == 0, done.stderr
    assert "end time reached" in done.stdout


@pytest.mark.soak
def test_a_craft_from_parts_is_whole_and_its_own_tests_pass(tmp_path):
    project = scaffold("scout", tmp_path, "craft")
    assert check(Tree(project), "scout").reasons == ()
    done = run(project, "pytest", "-q", "-p", "no:cacheprovider", "tests")
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.soak
def test_a_wrong_sign_is_compared_and_breaks_a_gate(tmp_path):
    project = scaffold("wrong", tmp_path)
    path = project / "models" / "wrong" / "system.py"
    text = path.read_text()
    assert "-p.m * p.g * p.l * sp.cos(X.theta)" in text
    shutil.copytree(project / "generated" / "wrong", tmp_path / "before")
    path.write_text(text.replace("[-U.torque, U.torque]", "[U.torque, U.torque]"))
    compared = run(project, "mehvar", "diff", str(tmp_path / "before"), "work")
    assert compared.returncode == 1, compared.stdout + compared.stderr
    assert "wrong: physics CHANGED" in compared.stdout
    assert run(project, "mehvar", "generate").returncode == 0
    done = run(project, "pytest", "-q", "-p", "no:cacheprovider", "tests", "-k", "physics")
    assert done.returncode == 1
    assert "'energy'" in done.stdout


@pytest.mark.parametrize("name", ["Wheel", "2wheels", "my-wheel", "", "a b"])
def test_a_name_that_cannot_name_a_system_is_refused(tmp_path, name):
    with pytest.raises(InputError, match="lower-case letters"):
        scaffold(name, tmp_path)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["class", "lambda", "None"])
def test_a_word_of_python_is_refused_as_one(tmp_path, name):
    with pytest.raises(InputError, match=f"NAME = '{name}': must be another name: this is a reserved word of Python"):
        scaffold(name, tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_an_existing_folder_is_left_alone(tmp_path):
    (tmp_path / "wheel").mkdir()
    with pytest.raises(InputError, match="exists"):
        scaffold("wheel", tmp_path)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("p.m * p.g", "p.mm * p.g", r"models/mine/system.py:\d+: AttributeError: group 'p' has no quantity 'mm'"),
        ("import sympy", "import sympyy", r"models/mine/system.py:9: ModuleNotFoundError: No module named 'sympyy'"),
        ("body + wheel - potential", "body wheel", r"models/mine/system.py:\d+: SyntaxError: invalid syntax"),
        ("d = Derivation()", "raise SystemExit(0)", r"models/mine/system.py:\d+: SystemExit: 0"),
        ("return System(", "return dict(", r"must be a System"),
        ('name="mine"', 'name="yours"', r"the system's name is 'yours' but must equal the folder's name, 'mine'"),
        (
            '"theta_ddot", rates',
            '"wheel", rates',
            r"models/mine/system.py:\d+: definition 'wheel' at .* of state 'wheel'",
        ),
        (
            "(X.theta_dot, angular, spin)",
            "(angular, spin)",
            r"models/mine/system.py:\d+: rhs has 2 entries for 3 states",
        ),
        (
            "from .system import system",
            "from .system import sistem",
            r"models/mine/__init__.py:3: ImportError: cannot import name 'sistem'",
        ),
        *(
            (
                '__all__ = ["system"]',
                f"STRUCTURE = {choices}",
                r"STRUCTURE = .*: must be a mapping",
            )
            for choices in ("None", "('a', 'b')", "{'a': 'b'}", "{1: ('a', 'b')}", "{'a': ()}")
        ),
    ],
)
@pytest.mark.share(2)
def test_a_mistake_in_a_model_is_one_line_and_nothing_is_written(tmp_path, mine, old, new, message):
    shutil.copytree(mine, tmp_path / "mine")
    model = tmp_path / "mine" / "models" / "mine"
    path = next(path for path in (model / "system.py", model / "__init__.py") if old in path.read_text())
    path.write_text(path.read_text().replace(old, new, 1))
    before = {p: p.read_bytes() for p in (tmp_path / "mine" / "generated").rglob("*.*")}
    done = run(tmp_path / "mine", "mehvar", "generate")
    assert done.returncode == 2
    assert re.fullmatch(rf"mehvar: .*{message}.*\n", done.stderr), done.stderr
    assert "mehvar_own" not in done.stderr
    assert "pip" not in done.stderr
    assert {p: p.read_bytes() for p in (tmp_path / "mine" / "generated").rglob("*.*")} == before


@pytest.fixture(scope="module")
def mine(tmp_path_factory):
    return scaffold("mine", tmp_path_factory.mktemp("mine"))


def test_a_misspelt_file_is_named_and_debug_shows_the_traceback(tmp_path, mine):
    shutil.copytree(mine, tmp_path / "mine")
    folder = tmp_path / "mine" / "models" / "mine"
    (folder / "system.py").rename(folder / "sytem.py")
    expected = f"mehvar: models/mine/__init__.py:3: imports {folder / 'system.py'}, which does not exist\n"
    assert run(tmp_path / "mine", "mehvar", "generate").stderr == expected
    for command in (["--debug", "generate"], ["generate", "--debug", "mine"]):
        done = run(tmp_path / "mine", "mehvar", *command)
        assert done.returncode == 2
        assert done.stderr.startswith("Traceback")
        assert done.stderr.endswith(expected)


@pytest.mark.parametrize(
    ("lost", "reason"), [("mine/__init__.py", "mine/__init__.py is missing"), ("mine", "mine is missing")]
)
def test_a_model_that_lost_its_text_is_told(tmp_path, mine, lost, reason):
    root = tmp_path / "mine"
    shutil.copytree(mine, root)
    scaffold("other", tmp_path)
    for room in ("models", "generated"):
        shutil.copytree(tmp_path / "other" / room / "other", root / room / "other")
    path = root / "models" / lost
    shutil.rmtree(path) if path.is_dir() else path.unlink()
    checked = run(root, "mehvar", "generate", "--check")
    assert (checked.returncode, checked.stdout.splitlines()[0]) == (1, "other: up to date")
    assert checked.stdout.splitlines()[1].startswith("mine: stale, because ")
    assert checked.stdout.endswith(f"{reason}\n")
    for command in (["generate"], ["generate", "mine"], ["generate", "--check", "mine"]):
        done = run(root, "mehvar", *command)
        assert done.returncode == 2
        assert reason in done.stderr
