# SPDX-License-Identifier: Apache-2.0
"""Sentences of a page come from its run: those that two runs share are true of any."""

import re

import pytest

import mehvar
from mehvar.cli.new import scaffold
from mehvar.pictures.run import panels_picture
from mehvar.pictures.style import style
from mehvar.report.page import Drawing, Stage, Text
from mehvar.report.subjects import run_sections
from mehvar.runtime.model.model import load
from tests.derived import REPRODUCED

OTHERWISE = {
    "triangle": ("path", {"theta_0": 0.3, "R": 0.6, "H": 0.01, "dt_out": 0.1}),
    "slosh": ("lyapunov-v2", {"m1": 60.0, "t_end": 80.0, "plant": "reduced"}),
    "satellite": ("pd", {"roll_0_deg": 3.0, "delay": 1}),
}
"""A law of each model, and what its second run has otherwise."""


def sentences(sections):
    """Return the sentences of a page: paragraphs, titles and captions."""
    texts = []
    for section in sections:
        texts.append(section.title)
        for block in section.blocks:
            if isinstance(block, Text):
                texts.append(block.text)
            elif isinstance(block, Stage):
                texts += [block.title, block.caption, *block.scene["runs"]]
            elif isinstance(block, Drawing):
                texts += [block.picture.title, block.picture.caption]
    return {part.strip() for text in texts for part in re.split(r"(?<=\.)\s", text)} - {""}


def said(dataset):
    return sentences(run_sections(dataset, load(dataset.attrs["model"]).manifest))


@pytest.mark.parametrize("name", REPRODUCED)
@pytest.mark.soak
def test_no_sentence_about_a_run_stays_when_the_run_is_another(name):
    law, settings = OTHERWISE[name]
    plain, other = (said(mehvar.simulate(name, law, **given)) for given in ({}, settings))
    shapes = f"Shown: {', '.join(shape.name for shape in load(name).manifest.geometry)}."
    headings = {"Animation", "Run", "Values", "Derivation", "Where it comes from", "Motion"}
    assert plain & other == headings | {shapes, "Drag the picture to look from another side."}
    for setting in settings:
        assert any(f"{setting} = " in sentence for sentence in other)
        assert not any(f"{setting} = " in sentence for sentence in plain)


@pytest.mark.soak
def test_the_page_of_a_batch_names_what_it_has_otherwise(tmp_path):
    def page(**given):
        out = tmp_path / f"{len(given)}.zarr"
        batch = mehvar.batch("triangle", "path", n=4, vary={"theta_0": "uniform(0.8, 1.2)"}, out=out, **given)
        return batch.mehvar.page()

    plain, other = page(), page(R=0.6, t_end=5.0)
    assert not {
        s for s in sentences(plain.sections) & sentences(other.sections) if re.search(r"\d", s.replace("95 %", ""))
    }
    assert plain.title.endswith("(scenario paper)")
    assert other.title.endswith("(scenario paper, R = 0.6, t_end = 5)")


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ({}, "(scenario paper)"),
        ({"theta_0": 0.3, "R": 0.65, "backend": "python"}, "(scenario paper, theta_0 = 0.3)"),
        ({"initial": {"theta": 0.2}, "t_end": 35.0}, "(scenario paper, theta = 0.2)"),
        ({"parameters": {"l1_0": 0.21, "l2_0": 0.21, "l3_0": 0.31, "theta_0": 0.9}, "rtol": 1e-9, "t_end": 5.0},
         "(scenario paper, l1_0 = 0.21, l2_0 = 0.21, l3_0 = 0.31, theta_0 = 0.9, 2 more)"),
    ],
)  # fmt: skip
@pytest.mark.share(4)
def test_titles_name_what_differs_from_the_scenario_and_nothing_else(given, text):
    run = mehvar.simulate("triangle", "path", **given)
    with style():
        assert panels_picture(run, load("triangle").manifest).get_suptitle().endswith(text)
    assert run.mehvar.page().title.endswith(text)


def test_titles_name_inputs_of_an_open_loop(tmp_path):
    folder = scaffold("wheel", tmp_path) / "generated" / "wheel"
    (name, *_) = load(folder).input_names
    run = mehvar.simulate(str(folder), None, inputs={name: 0.25})
    assert f"u_{name} = 0.25" in run.mehvar.page().title


def test_the_page_of_a_run_has_the_states_that_it_started_from():
    run = mehvar.simulate("satellite", "pd", t_end=1.0, initial={"wx": 0.3})
    (values,) = [s for s in run_sections(run, load("satellite").manifest) if s.anchor == "values"]
    (start,) = [block for block in values.blocks if block.title == "States at the start"]
    assert {row[0]: row[1:3] for row in start.rows}["wx"] == ("0.3", "rad/s")
