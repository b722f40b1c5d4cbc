# SPDX-License-Identifier: Apache-2.0
"""Contents of an FMU, and refusals; test_importers.py runs it."""

from __future__ import annotations

import zipfile
from xml.etree import ElementTree

import pytest

import mehvar
from mehvar.base.errors import InputError
from mehvar.parts import Hub, Spacecraft


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("fmu")


@pytest.mark.parametrize("fmi", ["2.0", "3.0"])
@pytest.mark.share(2)
def test_variables_are_the_manifests(fmi, folder):
    model = mehvar.load("triangle")
    mehvar.export_fmu("triangle", folder / "triangle.fmu", fmi=fmi, kind="me")
    with zipfile.ZipFile(folder / "triangle.fmu") as archive:
        assert archive.testzip() is None
        names = archive.namelist()
        root = ElementTree.fromstring(archive.read("modelDescription.xml"))
    assert root.get("fmiVersion") == fmi
    assert any(name.startswith("binaries/") for name in names)
    assert "sources/unit.c" in names
    variables = list(root.find("ModelVariables"))
    values = [element[0] if fmi == "2.0" else element for element in variables]
    named = {element.get("name"): value for element, value in zip(variables, values, strict=True)}
    assert [element.get("valueReference") for element in variables] == [str(k) for k in range(len(variables))]
    for parameter in model.manifest.parameters:
        assert float(named[f"plant.{parameter.name}"].get("start")) == parameter.default
    for state in model.manifest.states:
        assert named[state.name].get("unit", "1") == state.unit
    units = {unit.get("name"): unit[0].attrib for unit in root.find("UnitDefinitions")}
    assert units["m^2/s"] == {"m": "2", "s": "-1"}


@pytest.mark.soak
def test_the_same_model_gives_the_same_bytes_by_name_and_loaded(folder, monkeypatch):
    mehvar.export_fmu("triangle", folder / "a.fmu", controller="path")
    monkeypatch.setenv("MEHVAR_CACHE", str(folder / "cache"))  # which has no binary
    mehvar.export_fmu(mehvar.load("triangle"), folder / "b.fmu", controller="path")
    assert (folder / "a.fmu").read_bytes() == (folder / "b.fmu").read_bytes()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"out": "x.zip"}, "a file name that ends in .fmu"),
        ({"fmi": "1.0"}, "fmi = '1.0': must be '2.0' or '3.0'"),
        ({"kind": "se"}, "kind = 'se': must be 'me' or 'cs'"),
        ({"controller": "no"}, "unknown controller 'no' of triangle"),
        ({"scenario": "no"}, "unknown scenario 'no' of triangle"),
    ],
)
def test_what_is_not_there_is_refused(arguments, message, tmp_path):
    given = {"out": "x.fmu"} | arguments
    with pytest.raises(InputError, match=message):
        mehvar.export_fmu("triangle", tmp_path / given.pop("out"), **given)
    assert not list(tmp_path.iterdir())


def test_a_craft_without_a_law_is_a_plant_and_keeps_to_its_manifold(tmp_path):
    craft = Spacecraft("exported", "a hub alone")
    craft.add(Hub("hub", mass=120.0, inertia=(12.0, 14.0, 10.0)))
    mehvar.export_fmu(mehvar.build(craft), tmp_path / "hub.fmu")
    with zipfile.ZipFile(tmp_path / "hub.fmu") as archive:
        assert "->project" in archive.read("sources/fmu_model.h").decode()
