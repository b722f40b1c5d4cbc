# SPDX-License-Identifier: Apache-2.0
"""A law of one's own on a plant, and the project that it is in: from `mehvar new --from` to a run by its name."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import mehvar
from mehvar import runtime
from mehvar.base.errors import InputError
from mehvar.cli.new import scaffold_law
from mehvar.codegen import generate as generation
from mehvar.codegen.generate import GenerateError, Tree, generate
from mehvar.runtime.model.catalogue import project_models
from mehvar.settings import complete_models


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return scaffold_law("hover", "satellite", tmp_path_factory.mktemp("own"))


@pytest.mark.soak
def test_it_is_the_plant_under_another_law(project: Path) -> None:
    own, plant = runtime.load(project / "generated" / "hover"), runtime.load("satellite")
    assert (own.state_names, own.parameter_names) == (plant.state_names, plant.parameter_names)
    assert list(own.manifest.controllers) == ["hover"]
    assert "rms_roll" not in own.manifest.metrics  # memory of the reference model in the paper's laws
    x, u, p = plant.state(roll=0.3, wx=0.1, hz=1.0), [0.1, -0.2, 0.3], plant.parameters()
    np.testing.assert_array_equal(own.rhs(x, u, p), plant.rhs(x, u, p))
    gains = {f"gain_{u}": 0.01 for u in own.input_names}
    generated = mehvar.simulate(own, "hover", parameters=gains, t_end=5.0)
    python = mehvar.simulate("satellite", lambda _t, x: -0.01 * x[:3], period=0.5, t_end=5.0)
    for name in own.state_names:
        np.testing.assert_allclose(generated[name], python[name], rtol=0, atol=1e-12)


def test_a_second_law_derives_no_plant(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def derived(*_: object) -> None:
        raise AssertionError("the plant was derived again")

    text = (project / "models" / "hover" / "law.py").read_text()
    monkeypatch.setattr(generation, "_whole", derived)
    (project / "models" / "hover" / "law.py").write_text(text.replace("feedback of states", "feedback of angles"))
    assert generate(Tree(project), "hover").stale
    assert runtime.find_model(project / "generated" / "hover").controllers["hover"].title == "feedback of angles"


def test_its_text_follows_from_the_plant_too(project: Path) -> None:
    sources = Tree(project).sources("hover")
    assert {"models/hover/law.py", "models/hover/plant.toml", "models/satellite/dynamics.py"} <= sources.keys()


def test_the_project_is_known_by_its_names(project: Path, monkeypatch: pytest.MonkeyPatch, capsys) -> None:
    assert "hover" not in mehvar.list_models()
    monkeypatch.chdir(project / "models")
    assert mehvar.list_models() == ["hover", "satellite", "slosh", "triangle"]
    assert mehvar.load("hover").name == "hover"
    assert complete_models("ho") == ["hover"]
    with pytest.raises(InputError, match=r"unknown model .*'hovr'.*did you mean hover"):
        mehvar.load("hovr")
    with pytest.raises(InputError, match="hover exists; choose another"):
        scaffold_law("hover", "satellite", project)


def test_a_model_that_hides_one_of_mehvar_is_said(project: Path, tmp_path: Path, monkeypatch) -> None:
    (tmp_path / "models" / "triangle").mkdir(parents=True)
    (tmp_path / "models" / "triangle" / "system.py").touch()
    (tmp_path / "generated").mkdir()
    (tmp_path / "generated" / "triangle").symlink_to(project / "generated" / "hover")
    monkeypatch.chdir(tmp_path)
    assert project_models()["triangle"] == tmp_path / "generated" / "triangle"
    with pytest.warns(UserWarning, match=f"triangle: using the model in {tmp_path}.*not mehvar's model of this name"):
        runtime.find_model("triangle")


@pytest.mark.parametrize(
    ("text", "message"),
    [('plant = "satelite"', "unknown plant 'satelite'.*did you mean satellite"), ("x = 1", "must be one line, plant ="),
     ('plant = "hover"', "unknown plant 'hover'"), ('plant = ["hover"]', r"unknown plant \['hover'\]")],
)  # fmt: skip
def test_a_plant_that_is_none_is_refused(tmp_path: Path, text: str, message: str) -> None:
    folder = tmp_path / "models" / "hover"
    folder.mkdir(parents=True)
    (folder / "__init__.py").touch()
    (folder / "plant.toml").write_text(text)
    with pytest.raises(GenerateError, match=message):
        Tree(tmp_path).plant("hover")


@pytest.mark.parametrize(
    ("name", "plant", "message"),
    [("triangle", "satellite", "taken by a model that comes with mehvar"), ("mine", "no", "unknown model"),
     ("Mine", "satellite", "lower-case"), ("t_end", "satellite", "taken by an option")],
)  # fmt: skip
def test_names_that_are_none_are_refused(tmp_path: Path, name: str, plant: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        scaffold_law(name, plant, tmp_path)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("part", ["models/lean", "tests/test_lean.py", "generated/lean"])
def test_nothing_of_a_project_is_replaced(project: Path, monkeypatch: pytest.MonkeyPatch, part: str) -> None:
    place = project / part
    place.parent.mkdir(exist_ok=True)
    place.write_text("mine")
    monkeypatch.chdir(project)
    try:
        with pytest.raises(InputError, match=f"{part} exists; choose another"):
            scaffold_law("lean", "satellite", project)
        assert place.read_text() == "mine"
        assert [path for path in project.rglob("*lean*") if "cache" not in path.name] == [place]
    finally:
        place.unlink()
