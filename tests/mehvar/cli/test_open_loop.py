# SPDX-License-Identifier: Apache-2.0
"""`mehvar simulate --controller none`: inputs from the command line and from files; names that complete."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import mehvar
from mehvar.base.errors import InputError
from mehvar.cli.simulate import command
from mehvar.settings import complete_controllers, complete_models, complete_scenarios


def simulate(out: Path, **arguments: Any) -> Any:
    assert command(model="satellite", controller="none", t_end="4", out=out, **arguments) == 0
    return mehvar.open_result(out)


def test_inputs_come_from_flags_and_files(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "in.csv").write_text("t [s],Ty [N m]\n0,0\n2,0.001\n")
    first = simulate(tmp_path / "a.nc", inputs=tmp_path / "in.csv", input_texts=["Tx=0.01"])
    np.testing.assert_array_equal(first["u_Tx"], 0.01)
    np.testing.assert_array_equal(first["u_Ty"], np.where(first["t"] < 2, 0.0, 0.001))
    again = simulate(tmp_path / "b.nc", inputs=tmp_path / "a.nc")
    for name in ("roll", "pitch", "wx", "u_Ty"):
        np.testing.assert_array_equal(again[name], first[name])
    assert "satellite none paper: end time reached" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"input_texts": ["Ta=1"]}, r"unknown input 'Ta' of satellite \(from --input\)"),
        ({"input_texts": ["Tx=a"]}, "--input Tx = 'a': must be a number"),
        ({"input_texts": ["Tx"]}, "--input = 'Tx': must be NAME=VALUE"),
        ({"inputs": Path("no.csv")}, "cannot read no.csv"),
        ({"inputs": Path("no.txt")}, r"must be a file name that ends in \.nc or \.csv"),
        ({"controller": "pd", "input_texts": ["Tx=1"]}, "--input .*left out unless --controller is none"),
        (
            {"controller": "pd", "inputs": Path("a.csv")},
            "--inputs = 'a.csv': must be left out unless",
        ),
    ],
)
def test_other_inputs_are_refused(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        command(**{"model": "satellite", "controller": "none", **arguments})


def test_errors_of_a_file_name_it(tmp_path: Path) -> None:
    file = tmp_path / "in.csv"
    for rows, message in (("0,0\n2,0.1\n1,0\n", "instants must increase"), ("1,0\n", "the run begins at 0")):
        file.write_text(f"t [s],Ty [N m]\n{rows}")
        with pytest.raises(InputError, match=message) as refusal:
            command(model="satellite", controller="none", inputs=file)
        assert "--set" not in str(refusal.value)
        assert str(file) in str(refusal.value)
    file.write_text("t [s],Ty [N m]\n0,0\n2.00000012345,0.1\n")
    with pytest.raises(InputError, match=r"the instants of inputs \(from --inputs .*in.csv\): must be multiples"):
        command(model="satellite", controller="none", inputs=file)
    file.write_text("t [s],Ty [N m]\n0,0\n2,0.1\n")
    with pytest.raises(InputError, match=r"from --inputs .*in.csv\): must be known until the end of the run, 4 s"):
        command(model="satellite", controller="none", inputs=file, interpolation="linear", t_end="4")


def test_names_complete() -> None:
    context: Any = SimpleNamespace(params={"model": "satellite"})
    assert complete_models("s") == ["satellite", "slosh"]
    assert complete_controllers(context, "mrac") == ["mrac", "mrac-literal"]
    assert complete_scenarios(context, "p") == ["paper", "printed"]
    assert complete_controllers(SimpleNamespace(params={}, args=[]), "") == []  # type: ignore[arg-type]
