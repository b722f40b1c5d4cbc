# SPDX-License-Identifier: Apache-2.0
"""Inputs are what a derivation loaded: helpers beside the model, what they import, files, versions of libraries."""

import contextlib
import dataclasses
import importlib.metadata
import os
import re
import shutil
import sqlite3
import subprocess
import sys
from pathlib import Path

import pytest

from mehvar.base.manifest import manifest_text, read_manifest, with_digest
from mehvar.codegen.generate import Tree, check, installed_tree
from mehvar.codegen.watch import is_written
from tests import commands

ROOT = installed_tree().root
HEAD = """
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2] / "lib"))
import helper

(Path(__file__).parents[1] / "table.csv").read_text()
"""


def mehvar(folder: Path, *arguments: str) -> str:
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-P", "-m", "mehvar", *arguments]
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=True).stdout


@pytest.fixture(scope="module")
def derived(tmp_path_factory):
    """A system of a user's own that imports a helper from elsewhere, which imports another, and reads a table."""
    place = tmp_path_factory.mktemp("own")
    mehvar(place, "new", "wheel")
    folder = place / "wheel"
    for name, text in {
        "lib/helper.py": "import deeper\n",
        "lib/deeper.py": "GAIN = 1\n",
        "models/table.csv": "1\n",
    }.items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(text)
    start = folder / "models" / "wheel" / "__init__.py"
    start.write_text(HEAD + start.read_text())
    mehvar(folder, "generate")
    return folder


@pytest.fixture
def tree(derived, tmp_path):
    shutil.copytree(derived, tmp_path / "wheel")
    return Tree(tmp_path / "wheel")


def test_what_was_loaded_is_recorded_and_fresh(tree):
    recorded = read_manifest(tree.root / "generated" / "wheel").inputs_sha256
    assert {"lib/helper.py", "lib/deeper.py", "models/table.csv"} <= recorded.keys()
    assert not any(name.startswith("/") or "site-packages" in name for name in recorded)
    assert check(tree, "wheel").reasons == ()


@pytest.mark.parametrize("name", ["lib/helper.py", "lib/deeper.py", "models/table.csv", "models/wheel/system.py"])
def test_an_edit_of_what_was_loaded_is_stale(tree, name):
    path = tree.root / name
    path.write_text(path.read_text() + "\n")
    assert check(tree, "wheel").reasons == (f"{name} changed",)


def test_a_lost_helper_is_stale(tree):
    (tree.root / "lib" / "deeper.py").unlink()
    assert check(tree, "wheel").reasons == ("lib/deeper.py was removed",)


@pytest.mark.parametrize("library", ["sympy", "casadi"])
def test_another_version_of_a_library_is_stale(tree, library):
    path = tree.root / "generated" / "wheel" / "manifest.json"
    version = read_manifest(path.parent).versions[library]
    path.write_text(with_digest(path.read_text().replace(f'"{library}": "{version}"', f'"{library}": "0.1"')))
    assert check(tree, "wheel").reasons == (f"{library} is {version}, was 0.1",)


def test_a_new_title_of_a_scenario_derives_nothing(tree):
    path = tree.root / "models" / "wheel" / "scenarios.toml"
    text = path.read_text()
    path.write_text(re.sub(r'^title = ".*"', 'title = "another title"', text, count=1, flags=re.MULTILINE))
    assert path.read_text() != text
    before = read_manifest(tree.root / "generated" / "wheel")
    code = (
        "import sys; from pathlib import Path\n"
        "from mehvar.codegen.generate import find_tree, generate\n"
        "generate(find_tree(Path.cwd()), 'wheel')\n"
        "print([m for m in ('sympy', 'casadi') if m in sys.modules])"
    )
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    command = [commands.COLD, "-P", "-c", code]
    done = subprocess.run(command, cwd=tree.root, env=environment, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
    after = read_manifest(tree.root / "generated" / "wheel")
    assert check(tree, "wheel").reasons == ()
    assert "another title" in manifest_text(after)
    assert after.files_sha256 == before.files_sha256


@pytest.mark.parametrize("place", ["models/wheel/__pycache__/system.pyc", "kept/models/wheel/system.pyc"])
def test_bytecode_is_no_input_wherever_python_keeps_it(tmp_path, monkeypatch, place):
    monkeypatch.setattr(sys, "pycache_prefix", str(tmp_path / "kept"))
    assert is_written(tmp_path / place, tmp_path)
    assert not is_written(tmp_path / "models" / "wheel" / "system.py", tmp_path)


def test_files_elsewhere_links_databases_and_imported_libraries_are_inputs(derived, tmp_path):
    """A file counts wherever it lies, a link as what it leads to, a database although only the library opens it.

    What the system answers is no input, nor are libraries that the process has loaded and the model does not import.
    """
    tree = Tree(shutil.copytree(derived, tmp_path / "wheel"))
    far, link, base = tmp_path / "far" / "gain.csv", tree.root / "gain.csv", tree.root / "gains.db"
    far.parent.mkdir()
    for path in (far, tmp_path / "one", tmp_path / "other"):
        path.write_text(f"{path.name}\n")
    link.symlink_to(tmp_path / "one")
    with contextlib.closing(sqlite3.connect(base)) as made:
        made.execute("create table gains (value)")
    opening = "".join(f"open({str(path)!r}).close()\n" for path in (far, link, "/proc/self/status"))
    connecting = f"sqlite3.connect('file:{base}?mode=ro', uri=True).close()\nsqlite3.connect(':memory:').close()\n"
    start = tree.root / "models" / "wheel" / "__init__.py"
    start.write_text(f"import jinja2, sqlite3\n{opening}{connecting}{start.read_text()}")
    mehvar(tree.root, "generate")
    folder = tree.root / "generated" / "wheel"
    record = read_manifest(folder)
    assert [name for name in record.inputs_sha256 if name.startswith("..")] == ["../far/gain.csv"]
    assert not any(":memory:" in name for name in record.inputs_sha256)
    assert record.versions["Jinja2"] == importlib.metadata.version("jinja2")
    assert set(record.versions) == {"Jinja2", "casadi", "sympy"}
    assert check(tree, "wheel").reasons == ()
    link.unlink()
    link.symlink_to(tmp_path / "other")
    base.write_bytes(b"")
    far.write_text("2\n")
    changed = tuple(f"{name} changed" for name in ("../far/gain.csv", "gain.csv", "gains.db"))
    assert check(tree, "wheel").reasons == changed
    other = dataclasses.replace(record, versions={**record.versions, "Jinja2": "1.0"})
    (folder / "manifest.json").write_text(manifest_text(other))
    assert check(tree, "wheel").reasons == (*changed, f"Jinja2 is {record.versions['Jinja2']}, was 1.0")


ASKING = """
import os
from pathlib import Path

HERE = Path(__file__).parents[2]
WINGS = sorted(HERE.glob("wings/*.csv"))
NAMES = sorted(os.listdir(HERE / "names"))
LEAVES = sorted(entry.name for entry in os.scandir(HERE / "leaves"))
SWITCH = (HERE / "switch").exists()
FLAG = os.path.isfile(HERE / "flag")
LINK = os.path.exists(HERE / "link.csv") or (HERE / "chain.csv").is_file()
PLACE = (HERE / "place").exists()
try:
    TAIL = os.listdir(HERE / "tail")
except FileNotFoundError:
    TAIL = []
try:
    EXTRA = (HERE / "extra.csv").read_text()
except FileNotFoundError:
    EXTRA = ""
SIZE = os.environ.get("WHEEL_SIZE", "1")
GONE = os.getenv("WHEEL_GONE")
"""


@pytest.fixture(scope="module")
def asked(derived, tmp_path_factory):
    """A system whose text lists folders, looks for files that are not there and reads the environment."""
    folder = Path(shutil.copytree(derived, tmp_path_factory.mktemp("asked") / "wheel"))
    for name in ("wings", "names", "leaves"):
        (folder / name).mkdir()
        (folder / name / "first.csv").write_text("1\n")
    (folder / "switch").write_text("")
    for name, target in LINKS.items():
        (folder / name).symlink_to(target)
    start = folder / "models" / "wheel" / "__init__.py"
    start.write_text(ASKING + start.read_text())
    mehvar(folder, "generate")
    return folder


LINKS = {"link.csv": "nowhere.csv", "chain.csv": "link.csv", "models/wheel/.#system.py": "me@here.1"}
"""Links that lead nowhere: two that the model asks for, and the lock of an editor."""
ANSWERS = {
    "wings/second.csv": "wings/ changed", "names/second.csv": "names/ changed", "leaves/second.csv": "leaves/ changed",
    "extra.csv": "extra.csv is new", "flag": "flag is new", "switch": "switch was removed",
}  # fmt: skip


def test_what_a_model_asked_for_in_vain_is_fresh_until_it_is_there(asked, tmp_path):
    tree = Tree(shutil.copytree(asked, tmp_path / "wheel", symlinks=True))
    assert check(tree, "wheel").reasons == ()
    for name, reason in ANSWERS.items():
        path = tree.root / name
        exists = path.exists()
        path.unlink() if exists else path.write_text("")
        assert check(tree, "wheel").reasons == (reason,)
        path.write_text("") if exists else path.unlink()
    assert check(tree, "wheel").reasons == ()


@pytest.mark.parametrize(
    ("change", "reasons"),
    [
        (lambda root: (root / "nowhere.csv").write_text(""), ("chain.csv is new", "link.csv is new")),
        (lambda root: _lead(root / "link.csv", "setup.py"), ("chain.csv is new", "link.csv is new")),
        (lambda root: _lead(root / "chain.csv", "switch"), ("chain.csv is new",)),
        (lambda root: (root / "place").mkdir(), ("place is new",)),
        (lambda root: (root / "tail").mkdir(), ("tail/ is new",)),
    ],
    ids=["target", "link", "chain", "folder", "listed"],
)
def test_a_link_that_led_nowhere_and_a_folder_that_was_missing_are_inputs(asked, tmp_path, change, reasons):
    """Both went unnoticed, and the generated files stayed as they were."""
    tree = Tree(shutil.copytree(asked, tmp_path / "wheel", symlinks=True))
    (tree.root / "setup.py").write_text("")
    assert check(tree, "wheel").reasons == ()
    change(tree.root)
    assert check(tree, "wheel").reasons == reasons


def _lead(link, target):
    link.unlink()
    link.symlink_to(target)


@pytest.mark.parametrize("name", ["WHEEL_SIZE", "WHEEL_GONE"])
def test_a_variable_of_the_environment_is_an_input(asked, monkeypatch, name):
    assert check(Tree(asked), "wheel").reasons == ()
    monkeypatch.setenv(name, "2")
    assert check(Tree(asked), "wheel").reasons == (f"environment:{name} is new",)
    monkeypatch.delenv(name)
    assert check(Tree(asked), "wheel").reasons == ()


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("import subprocess\nsubprocess.run(['true'])\n", "starts a program"),
        ("import os\nos.system('true')\n", "starts a program"),
        ("import os\nos.popen('true').read()\n", "starts a program"),
        ("import socket\nsocket.create_connection(('localhost', 9), 1)\n", "contacts another machine"),
    ],
)
def test_what_other_programs_answer_is_refused(derived, tmp_path, text, word):
    tree = Tree(shutil.copytree(derived, tmp_path / "wheel"))
    start = tree.root / "models" / "wheel" / "__init__.py"
    start.write_text(text + start.read_text())
    with pytest.raises(subprocess.CalledProcessError) as failure:
        mehvar(tree.root, "generate")
    assert word in failure.value.stderr
    assert "__init__.py:2" in failure.value.stderr
