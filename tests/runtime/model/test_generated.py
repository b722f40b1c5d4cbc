# SPDX-License-Identifier: Apache-2.0
"""Edited files of a generated folder do not run, and stale ones are told."""

from __future__ import annotations

import shutil
import warnings
from collections.abc import Callable
from pathlib import Path

import pytest

import mehvar
from mehvar.base.manifest import read_manifest
from mehvar.runtime import InputError, load
from mehvar.runtime.batch.source import generated_sources
from mehvar.runtime.board.image.build import program, sources
from mehvar.runtime.model.generated import generated_text
from mehvar.runtime.model.model import Model
from tests.fuzz.campaign import in_process

ROOT = Path(mehvar.__file__).parents[1]


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A project with the triangle, and nothing of the vocabulary."""
    for part in ("models", "generated"):
        shutil.copytree(ROOT / part / "triangle", tmp_path / part / "triangle")
    return tmp_path


def rhs(model: Model, name: str = "rhs") -> object:
    return model.functions[name](model.state(rho=0.1), [0.0, 0.0, 0.0], model.parameters())


@pytest.mark.parametrize(
    ("file", "use"),
    [
        ("triangle.h", lambda f: load(f, "c")),
        ("triangle.h", lambda f: generated_sources(read_manifest(f))),
        ("triangle.c", lambda f: rhs(load(f, "c"))),
        ("triangle.c", lambda f: sources(program(load(f, "c"), "path"), None)),
        ("triangle_jac.c", lambda f: rhs(load(f, "c"), "jac_x")),
        ("triangle_prepared.c", lambda f: generated_sources(read_manifest(f))),
        ("triangle.py", lambda f: rhs(load(f, "python"))),
    ],
)
def test_text_that_was_edited_is_not_run(project: Path, file: str, use: Callable[[Path], object]) -> None:
    folder = project / "generated" / "triangle"
    text = (folder / file).read_text()
    (folder / file).write_text(text.replace("1.0", "1.5", 1) if "1.0" in text else text + "\n")
    with pytest.raises(InputError, match=rf"{file} was changed after generation"):
        use(folder)


def test_every_file_is_held_against_the_manifest(project: Path) -> None:
    folder = project / "generated" / "triangle"
    manifest = read_manifest(folder)
    assert len(manifest.files_sha256) > 7
    for name in manifest.files_sha256:
        text = (folder / name).read_bytes()
        assert generated_text(manifest, name).encode() == text
        for other in (text + b" ", text[:-1], text.replace(b" ", b"  ", 1), b"", None):
            (folder / name).unlink() if other is None else (folder / name).write_bytes(other)
            with pytest.raises(InputError, match=r"generate the model again|run mehvar generate"):
                generated_text(manifest, name)
        (folder / name).write_bytes(text)


def test_a_command_refuses_edited_code(project: Path) -> None:
    folder = project / "generated" / "triangle"
    file = folder / "triangle.c"
    file.write_text(file.read_text() + "\n")
    for command in (
        ("simulate", str(folder), "--controller", "path"),
        ("batch", str(folder), "--controller", "path", "-n", "2", "--out", str(project / "a.zarr")),
        ("board", "build", str(folder), "--controller", "path", "--target", "sil"),
        ("export", "fmu", str(folder), "--out", str(project / "a.fmu")),
    ):
        status, text = in_process(*command)
        assert (status, "triangle.c was changed after generation" in text) == (2, True), text


@pytest.mark.parametrize("name", ["parameters.toml", "scenarios.toml", "system.py"])
def test_a_source_that_changed_since_is_told(project: Path, name: str) -> None:
    folder, file = project / "generated" / "triangle", project / "models" / "triangle" / name
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        load(folder, "python")
    file.write_text(file.read_text() + "\n")
    with pytest.warns(RuntimeWarning, match=rf"triangle is stale: models/triangle/{name} changed after generation"):
        load(folder, "python")
    file.unlink()  # generated text alone, as in a package of it, is nobody's mistake
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        load(folder, "python")


@pytest.mark.parametrize("name", ["triangle.c", "equations.json", "equations.md"])
@pytest.mark.share(3)
def test_what_is_shown_or_compared_is_what_generation_wrote(project: Path, name: str) -> None:
    folder = project / "generated" / "triangle"
    before = project / "before"
    shutil.copytree(folder, before)
    assert in_process("diff", str(before), str(folder))[0] == 0
    (folder / name).write_text((folder / name).read_text().replace("1", "2", 1))
    for command in (
        ("diff", str(before), str(folder)),
        ("diff", str(folder), str(before)),
        ("report", str(folder), "--out", str(project / "report")),
    ):
        status, text = in_process(*command)
        assert (status, f"{name} was changed after generation" in text) == (2, True), text
    assert not (project / "report").exists()


def test_an_edited_page_is_not_shown(project: Path) -> None:
    folder = project / "generated" / "triangle"
    model = load(folder, "python")
    page = folder / "equations.md"
    page.write_text(page.read_text() + "\n")
    with pytest.raises(InputError, match=r"equations.md was changed after generation"):
        model._repr_latex_()
