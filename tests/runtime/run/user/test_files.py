# SPDX-License-Identifier: Apache-2.0
"""Inputs from files: a result and a table say the same as the arrays in them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import mehvar
from mehvar import runtime
from mehvar.base.errors import InputError
from mehvar.runtime.run.user.files import read_inputs


def test_results_and_tables_are_read(pendulum: runtime.Model, tmp_path: Path) -> None:
    manifest = pendulum.manifest
    dataset = runtime.to_dataset(runtime.simulate(pendulum, "p-sum", t_end=0.5, parameters={"Ts": 0.05}))
    runtime.save(dataset, tmp_path / "run.nc")
    runtime.save(dataset, tmp_path / "run.csv")
    (tmp_path / "table.csv").write_text("t,torque [N m]\n0,0.5\n0.1,-1\n")
    assert "u_cmd_torque" in read_inputs(tmp_path / "run.nc", manifest)
    t, values = read_inputs(tmp_path / "run.csv", manifest)["torque"]
    np.testing.assert_array_equal(t, dataset["t"])
    np.testing.assert_array_equal(values, dataset["u_cmd_torque"])
    np.testing.assert_array_equal(read_inputs(tmp_path / "table.csv", manifest)["torque"], ([0, 0.1], [0.5, -1]))


def test_a_table_of_a_delayed_run_repeats_it(pendulum: runtime.Model, tmp_path: Path) -> None:
    """A table has no delay, so its commands would act too early."""
    run = runtime.simulate(pendulum, "p-sum", t_end=0.5, parameters={"Ts": 0.05}, dt_out=0.05, delay=2)
    dataset = runtime.to_dataset(run)
    for ending in ("csv", "nc"):
        runtime.save(dataset, tmp_path / f"run.{ending}")
        again = mehvar.simulate(pendulum, None, inputs=read_inputs(tmp_path / f"run.{ending}", pendulum.manifest),
                                t_end=0.5, dt_out=0.05)  # fmt: skip
        for name in pendulum.state_names:
            np.testing.assert_array_equal(again[name], dataset[name])


def test_an_input_without_prefix_is_read_beside_one_with_it(tmp_path: Path) -> None:
    (tmp_path / "mixed.csv").write_text("t,u_w1,w2\n0,0.1,0.2\n")
    table = read_inputs(tmp_path / "mixed.csv", mehvar.load("triangle").manifest)
    assert {name: float(values[0]) for name, (_, values) in table.items()} == {"w1": 0.1, "w2": 0.2}


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.txt", "", r"a.txt'.*ends in \.nc or \.csv"),
        ("a.csv", "", "columns of .*a.csv = '': must be t"),
        ("a.csv", "torque\n1\n", "columns of .*a.csv = 'torque': must be t"),
        ("a.csv", "t,torque\n", "rows of .*a.csv = 0: must be one or more"),
        ("a.csv", "t;torque\n0;1\n", "columns of .*a.csv = 't;torque': must be t"),
        ("a.csv", "t,torqe\n0,1\n", "unknown input 'torqe' of pendulum.*a.csv"),
        ("a.csv", "t [ms],torque\n0,1\n", r"unit of t in .*a.csv = 'ms': must be s, or left out"),
        ("a.csv", "t,torque [mN m]\n0,1\n", "unit of torque in .*must be N m, or left out"),
        ("a.csv", "t,torque,torque\n0,1,2\n", "columns of .*must be one of each name"),
        ("a.csv", "t,torque,u_torque\n0,1,2\n", "columns of .*must be one column of torque"),
        ("a.csv", "t,torque\n0,x\n", r"line 2 of .*a.csv = '0,x': must be 2 numbers"),
        ("a.csv", "t,torque\n0,1_0\n", "line 2 of .*must be 2 numbers"),
        ("a.csv", "t,torque\n0,١\n", "line 2 of .*must be 2 numbers"),
        ("a.csv", "t,torque\n0,1,2\n", "line 2 of .*must be 2 numbers"),
        ("a.csv", "t,torque\n0,1\n1\n", "line 3 of .*must be 2 numbers"),
    ],
)
def test_other_files_are_refused(pendulum: runtime.Model, tmp_path: Path, name: str, text: str, message: str) -> None:
    (tmp_path / name).write_text(text)
    with pytest.raises(InputError, match=message):
        read_inputs(tmp_path / name, pendulum.manifest)
