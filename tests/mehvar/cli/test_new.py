# SPDX-License-Identifier: Apache-2.0
"""`mehvar new`: the new system generates, simulates and passes its gates; a wrong term does not."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from mehvar.cli.new import scaffold
from mehvar.codegen.generate import Tree, check
from mehvar.errors import InputError

ROOT = Path(__file__).parents[3]


def run(folder: Path, *command: str) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    return subprocess.run(
        [sys.executable, "-m", *command], cwd=folder, env=environment, capture_output=True, text=True, check=False
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


@pytest.mark.parametrize("name", ["Wheel", "2wheels", "my-wheel", "class", "", "a b"])
def test_a_name_that_cannot_name_a_system_is_refused(tmp_path, name):
    with pytest.raises(InputError, match="lower-case letters"):
        scaffold(name, tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_an_existing_folder_is_left_alone(tmp_path):
    (tmp_path / "wheel").mkdir()
    with pytest.raises(InputError, match="exists"):
        scaffold("wheel", tmp_path)
