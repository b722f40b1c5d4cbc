# SPDX-License-Identifier: Apache-2.0
"""The wheel: what is in it, and its use from another folder in an environment of its own."""

import subprocess
import sys
import sysconfig
import tarfile
import venv
import zipfile
from pathlib import Path

import pytest

from tests.gates.elsewhere import FURTHER, walk

ROOT = Path(__file__).parents[2]


BESIDE = ("models", "codegen", "generated", "runtime")
"""Folders of the repository that a wheel has inside mehvar/."""


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """The wheel that is built from the unpacked source distribution."""
    place = tmp_path_factory.mktemp("wheel")
    build = [sys.executable, "-m", "hatchling", "build", "-d", place, "-t"]
    subprocess.run([*build, "sdist"], cwd=ROOT, check=True, capture_output=True)
    (sources,) = place.glob("*.tar.gz")
    with tarfile.open(sources) as archive:
        archive.extractall(place / "unpacked", filter="data")
    (unpacked,) = (place / "unpacked").iterdir()
    subprocess.run([*build, "wheel"], cwd=unpacked, check=True, capture_output=True)
    (built,) = place.glob("*.whl")
    return built


@pytest.fixture(scope="module")
def programs(wheel):
    """An environment with the wheel; numpy and the like come from the environment of the tests, this package not."""
    place = wheel.parent / "env"
    venv.create(place, with_pip=False)
    python = place / "bin" / "python"
    install = ["install", "--quiet", "--no-compile", "--no-deps", "--no-index", wheel]
    subprocess.run([sys.executable, "-m", "pip", "--python", python, *install], check=True)
    site = next((place / "lib").glob("python*/site-packages"))
    (site / "others.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return python.parent


def test_it_holds_what_is_committed_and_nothing_else(wheel):
    """Under the one name `mehvar`, by way of the source distribution."""
    git = ["git", "ls-files", "--cached", "--others", "--exclude-standard", "mehvar", *BESIDE]
    files = subprocess.run(git, cwd=ROOT, check=True, capture_output=True, text=True).stdout.split()
    files = [name for name in files if not (ROOT / name).is_symlink()]
    expected = {f"mehvar/{name}" if name.startswith(tuple(f"{room}/" for room in BESIDE)) else name for name in files}
    with zipfile.ZipFile(wheel) as archive:
        names = {name for name in archive.namelist() if ".dist-info/" not in name}
    assert names == {
        name for name in expected if (ROOT / name.removeprefix("mehvar/")).exists() or (ROOT / name).exists()
    }


@pytest.mark.peers
def test_the_package_index_would_take_it(wheel):
    """`twine check` accepts metadata and README."""
    (sources,) = wheel.parent.glob("*.tar.gz")
    check = [sys.executable, "-m", "twine", "check", "--strict", wheel, sources]
    done = subprocess.run(check, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize("further", [(), pytest.param(FURTHER, marks=pytest.mark.soak)], ids=["some", "all"])
def test_everything_works_from_another_folder(programs, tmp_path, further):
    assert walk(programs, tmp_path, further) == []
