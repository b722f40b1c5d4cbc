# SPDX-License-Identifier: Apache-2.0
"""Functions that a generated folder leaves out are made when first used: once, the same, of unchanged sources."""

import os
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mehvar.base.errors import InputError
from mehvar.base.manifest import files_on_first_use, read_manifest
from mehvar.codegen.generate import installed_tree
from mehvar.runtime.model import derived
from mehvar.runtime.model.catalogue import find_model
from mehvar.runtime.model.derived import folder_with
from mehvar.runtime.model.model import load

FILES = sorted(files_on_first_use("triangle"))


@pytest.fixture
def tree(tmp_path) -> Path:
    """A copy of models/ and generated/ that a test may change; returns the folder of the triangle."""
    for name in ("models", "generated"):
        root = installed_tree().root
        shutil.copytree(root / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"))
    return tmp_path / "generated" / "triangle"


@pytest.mark.parametrize("model", ["triangle", "satellite", "slosh"])
@pytest.mark.share(3)
def test_python_has_every_derivative(model):
    """CasADi's C is compared with ours by tests/mehvar/report/test_backends.py."""
    ours, python = load(model, "c"), load(model, "python")
    random = np.random.default_rng(1)
    for f in (f for f in ours.manifest.functions.values() if f.file.endswith("_jac.c")):
        arguments = [random.uniform(0.2, 0.9, a.shape) for a in f.arguments]
        arguments = [ours.parameters() if a.name == "p" else v for a, v in zip(f.arguments, arguments, strict=True)]
        one, other = (flat(m.functions[f.name](*arguments)) for m in (ours, python))
        # both compute the same operations; only sines and the like differ, and a wrong operation shows at once
        np.testing.assert_allclose(other, one, rtol=1e-9, atol=1e-9, err_msg=f.name)


def flat(results) -> np.ndarray:
    return np.concatenate([np.ravel(r) for r in (results if isinstance(results, tuple) else (results,))])


def test_a_copied_folder_takes_the_sources_of_the_installed_model(tmp_path):
    folder = shutil.copytree(find_model("triangle").folder, tmp_path / "copy")
    made = {folder_with(read_manifest(folder), name).folder for name in FILES}
    assert made == {folder_with(find_model("triangle"), FILES[0]).folder}, "one derivation for all files"


@pytest.mark.soak
def test_a_folder_of_another_structure_gets_files_of_that_structure(tree, tmp_path):
    shutil.rmtree(tree)
    options = ("--structure", "masses=general", "--out", str(tree))
    assert derived.run_python(tmp_path, "-m", "mehvar", "generate", "triangle", *options).returncode == 0
    manifest = read_manifest(tree)
    made = folder_with(manifest, "triangle_casadi.c")
    assert made.folder != tree
    assert made.structure == manifest.structure != find_model("triangle").structure
    assert made.hash == manifest.hash


def test_files_of_other_functions_are_refused_though_these_are_called_alike(tree):
    """The functions are compared, not only their names: sources may be derived otherwise tomorrow."""
    manifest = replace(read_manifest(tree), hash="0" * 64)
    for name in FILES:
        with pytest.raises(InputError, match=r"derives other functions \(hash \w{8}\) than .* has \(0{8}\); generate"):
            folder_with(manifest, name)


def test_changed_sources_are_refused(tree):
    source = tree.parents[1] / "models" / "triangle" / "dynamics.py"
    source.write_text(source.read_text() + "\n# later\n")
    message = r"cannot be made: models/triangle/dynamics\.py has changed since .*run: mehvar generate triangle"
    for name in FILES:
        with pytest.raises(InputError, match=message):
            folder_with(read_manifest(tree), name)
    with pytest.warns(RuntimeWarning, match="changed after generation"), pytest.raises(InputError, match=message):
        load(tree, "casadi")


def test_a_folder_without_its_sources_says_what_to_type(tree):
    manifest = read_manifest(tree)
    shutil.rmtree(tree.parents[1] / "models" / "triangle")
    manifest.__dict__["text"] = "of nobody's"
    with pytest.raises(
        InputError,
        match=r"cannot be derived without the sources models/triangle.* generate triangle --out",
    ):
        folder_with(manifest, "triangle_casadi.c")


def test_a_leftover_of_another_derivation_is_not_read(tree):
    (tree / "triangle_loops_jac.c").write_text("#error left over")
    model = load(tree)
    assert folder_with(model.manifest, "triangle_loops_jac.c").folder != tree
    point = model.state(rho=0.3, phi=0.1, mu=0.2, theta=0.4)
    assert np.isfinite(model.linearize(point, None, model.parameters(), controller="path").A).all()


def test_without_casadi_the_package_is_named(monkeypatch):
    monkeypatch.setattr(derived, "installed", lambda *names: {n: "1" for n in names if n != "casadi"})
    with pytest.raises(InputError, match=r"made when it is first used, which needs casadi: pip install casadi"):
        folder_with(find_model("triangle"), "triangle_casadi.c")


@pytest.mark.soak
def test_two_processes_at_once_and_a_folder_that_cannot_be_written(tree, tmp_path):
    """Both derive, one entry stays; nothing is written beside the sources."""
    for path in (tree, *tree.iterdir()):
        path.chmod(0o555)
    code = (
        "import sys; from mehvar.base.manifest import read_manifest; from mehvar.runtime.model.derived import holder\n"
        "print(holder(read_manifest(sys.argv[1]), 'triangle_loops_jac.c').folder)"
    )
    (tmp_path / "cache").mkdir(mode=0o700)
    environment = {**os.environ, "MEHVAR_CACHE": str(tmp_path / "cache")}
    before = sorted(path for path in tree.parents[1].rglob("*") if "cache" not in str(path.relative_to(tmp_path)))
    command = [sys.executable, "-c", code, str(tree)]
    both = [subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True) for _ in range(2)]
    folders = {process.communicate()[0].strip() for process in both}
    assert [process.returncode for process in both] == [0, 0]
    (made,) = (tmp_path / "cache" / "derived").iterdir()
    assert folders == {str(made)}
    after = sorted(path for path in tree.parents[1].rglob("*") if "cache" not in str(path.relative_to(tmp_path)))
    assert after == before
    assert not (made / "triangle_loops_jac.c").stat().st_mode & 0o022
