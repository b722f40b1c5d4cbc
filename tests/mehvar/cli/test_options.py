# SPDX-License-Identifier: Apache-2.0
"""The command line, campaign files and Python take the options of the table, and say of them what the table says."""

from __future__ import annotations

import dataclasses
import inspect
from pathlib import Path
from typing import Any, get_args

import pytest
import typer

import mehvar
from mehvar.campaign import CampaignFile
from mehvar.cli import app, batch, simulate
from mehvar.cli.board import loop
from mehvar.runtime.batch.plan import CAMPAIGN_OPTIONS, Campaign
from mehvar.runtime.board.run import BoardRequest
from mehvar.runtime.model.catalogue import find_model, known_models
from mehvar.runtime.run.options import OPTIONS, RunOptions
from mehvar.settings import read_values

ROWS = {**OPTIONS, **CAMPAIGN_OPTIONS}
FLAGS = {"save": "save_every"}


def value_of(name: str) -> Any:
    row = OPTIONS[name]
    return row.words[-1] if row.words else 3 if row.kind == "count" else 0.25


def flags(command: Any) -> dict[str, Any]:
    """Return the flags of a command by name."""
    click = typer.main.get_command(_typer(command))
    return {parameter.name: parameter for parameter in click.params}


def _typer(command: Any) -> typer.Typer:
    single = typer.Typer()
    single.command()(command)
    return single


@pytest.mark.parametrize("command", [simulate.command, batch.command], ids=["simulate", "batch"])
def test_a_flag_of_an_option_has_its_text_and_no_default_of_its_own(command):
    own = {name: flag for name, flag in flags(command).items() if FLAGS.get(name, name) in ROWS}
    own.pop("run", None)  # which run of a batch to repeat
    assert "t_end" in own
    for name, flag in own.items():
        assert flag.help == ROWS[FLAGS.get(name, name)].help
        assert flag.default is None


@pytest.mark.parametrize("name", OPTIONS)
def test_set_and_a_campaign_file_take_every_option_or_say_why_not(name):
    values = read_values([f"{name}={value_of(name)}"], find_model("triangle"))
    file = CampaignFile(model="triangle", controller="path", n=2, set=values)
    model = mehvar.load("triangle", backend="c")
    board = loop.with_settings, model, BoardRequest("path"), [f"{name}={value_of(name)}"]
    for place, call in (("batch", lambda: file.campaign("here")), ("board", lambda: board[0](*board[1:]))):
        if place in OPTIONS[name].refused:
            with pytest.raises(mehvar.InputError, match=f"^{name} = "):
                call()
        else:
            assert dict(call().options) == {name: value_of(name)}


def test_a_campaign_file_has_the_fields_and_defaults_of_a_campaign():
    fields = {f.name: f for f in dataclasses.fields(CampaignFile)}
    assert {name for name in CAMPAIGN_OPTIONS if name != "save_every"} <= fields.keys()
    for name in ("seed", "sampling"):
        assert fields[name].default == getattr(Campaign, name) == CAMPAIGN_OPTIONS[name].default
        assert inspect.signature(mehvar.batch).parameters[name].default is None, (
            "what is given beside a file is refused"
        )


def test_an_option_that_comes_twice_is_refused(tmp_path: Path):
    with pytest.raises(mehvar.InputError, match="t_end is given twice"):
        CampaignFile(model="triangle", controller="path", n=2, t_end=1.0, set={"t_end": 2.0}).campaign("here")
    with pytest.raises(mehvar.InputError, match="R is given twice"):
        mehvar.batch("triangle", "path", 2, parameters={"R": 0.6}, R=0.61)
    (tmp_path / "campaign.toml").write_text("model = 'triangle'\ncontroller = 'path'\nn = 2\n")
    for more in ({"seed": 0}, {"controller": "sliding"}, {"rtol": 1e-9}, {"initial": {}}, {"sampling": "random"}):
        with pytest.raises(mehvar.InputError, match=f"^{next(iter(more))} = .*left out: .* determines the run"):
            mehvar.batch(tmp_path / "campaign.toml", **more)


def test_no_parameter_or_choice_of_a_model_is_called_like_an_option():
    """An option would hide it."""
    for name in known_models():
        manifest = find_model(name)
        names = {q.name for q in (*manifest.parameters, *manifest.scenario_parameters)} | manifest.choices.keys()
        assert not names & OPTIONS.keys()


def test_every_command_that_is_listed_can_be_called():
    alone = {**app.COMMANDS, **app.FOR_GIT}
    for room, commands in (("", alone), ("board.", app.BOARD), ("export.", app.EXPORT)):
        for name, text in commands.items():
            place = app.PLACES.get(name, name) if commands is alone else name
            module = __import__(f"mehvar.cli.{room}{place.replace('-', '_')}", fromlist=["command"])
            assert callable(module.command)
            assert text.endswith((".", "--run ID.", "--resume."))


def test_words_of_options_are_one_list():
    for name, field in RunOptions.__annotations__.items():
        if OPTIONS[name].words and "None" not in field:
            hints = inspect.get_annotations(RunOptions, eval_str=True)[name]
            assert get_args(hints) == OPTIONS[name].words
