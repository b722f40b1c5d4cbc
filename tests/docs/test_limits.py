# SPDX-License-Identifier: Apache-2.0
"""Each line of docs/known-limits.md names the test that shows it; those that stand nowhere else are here."""

from __future__ import annotations

import json
import re
import shlex
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray

import mehvar
from mehvar.base.errors import MehvarError
from mehvar.base.manifest import SHAPE_KINDS
from mehvar.cli.new import scaffold
from mehvar.runtime.model.model import load
from tests.fuzz.campaign import in_process

ROOT = Path(__file__).parents[2]
LINES = re.findall(r"^- .*\n(?:  .*\n)*", (ROOT / "docs" / "known-limits.md").read_text(encoding="utf-8"), re.MULTILINE)
HOW = re.compile(r"^  <!--(test|untried): ?(.+)-->\n", re.MULTILINE)


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def cli(line: str) -> str:
    """Return the output of a command."""
    return in_process(*shlex.split(line))[1]


def refusal(call: Callable[[], object]) -> str:
    """Return why a call is refused, or nothing."""
    try:
        call()
    except MehvarError as error:
        return str(error)
    return ""


def page(name: str) -> str:
    """Return the text of a file of the checkout."""
    return (ROOT / name).read_text(encoding="utf-8")


def steps(method: str, k_phi: float) -> int:
    """Return the steps of the triangle's run under the path law at a tolerance of 1e-6."""
    run = mehvar.simulate("triangle", "path", method=method, rtol=1e-6, atol=1e-6, k_phi=k_phi)
    return int(json.loads(run.attrs["statistics"])["steps"])


def value(run: xarray.Dataset, name: str) -> float:
    """Return a parameter of a run."""
    return float(json.loads(run.attrs["parameters"])[name])


@pytest.mark.parametrize("line", LINES, ids=lambda line: line[2:42])
def test_a_line_says_how_one_knows(line: str) -> None:
    ((how, what),) = HOW.findall(line)
    if how == "test":
        file, _, name = what.partition("::")
        assert f"def {name}" in page(file), what


@pytest.mark.soak
def test_readings_are_marked() -> None:
    assert "assumption: " in cli("show triangle")


@pytest.mark.soak
def test_the_triangle_is_kinematic() -> None:
    assert load("triangle").manifest.structure == {"masses": "equal", "model": "kinematic", "rods": "light"}


@pytest.mark.soak
def test_rods_have_no_least_length() -> None:
    assert 0.0535 <= mehvar.simulate("triangle", "path").min_length < 0.0545


@pytest.mark.soak
def test_slosh_keeps_table_1() -> None:
    kept = {"I1": 10.0, "I2": 1.0, "eps1": 3.57, "eps2": 0.15}
    assert {q.name: q.default for q in load("slosh").manifest.parameters if q.name in kept} == kept


@pytest.mark.soak
def test_wheels_turn_too_fast() -> None:
    run = mehvar.simulate("satellite", "mrac")
    fastest = max(float(abs(run[f"h{axis}"]).max()) / value(run, f"Iw_{axis}") for axis in "xyz")
    assert 86e3 < fastest * 30 / np.pi < 88e3


@pytest.mark.soak
def test_rodas5p_is_slow_at_a_kink() -> None:
    assert 120 < steps("rodas5p", 0.33) < 160
    assert steps("rodas5p", 0.69) > 12e3
    assert 95 < steps("dop853", 0.69) < 125


@pytest.mark.soak
def test_batches_are_double() -> None:
    said = refusal(lambda: mehvar.batch("triangle", "path", n=2, hold=0.02, real="float", out="f.zarr"))
    assert "a batch computes in double" in said


@pytest.mark.soak
@pytest.mark.parametrize("name", ["Ts", "delay"])
def test_what_decides_when_cannot_vary(name: str) -> None:
    said = refusal(lambda: mehvar.batch("satellite", "mrac", n=2, vary={name: "uniform(0, 1)"}, out="a.zarr"))
    assert "it determines the sample times" in said


@pytest.mark.soak
def test_metrics_miss_what_is_between_samples() -> None:
    rare, often = mehvar.simulate("satellite", "mrac", dt_out=25.0), mehvar.simulate("satellite", "mrac")
    assert rare.late_torque_z < often.late_torque_z / 10


@pytest.mark.soak
def test_no_invariant_is_monitored() -> None:
    names = list(mehvar.batch("triangle", "path", n=2, out="g.zarr").data_vars)
    assert "error" in names
    assert not [name for name in names if "invariant" in str(name)]


@pytest.mark.soak
def test_a_constant_by_zero_is_refused() -> None:
    assert "1/0" in refusal(lambda: mehvar.batch("triangle", "path", n=2, success="T_theta < 1/0", out="a.zarr"))


@pytest.mark.soak
def test_laws_in_numbers_have_no_units() -> None:
    assert "in_numbers" in page("models/satellite/controllers.py")


@pytest.mark.soak
@pytest.mark.parametrize(
    ("name", "rows"),
    [
        ("benchmarks/results/growth.md", ("| 2 | 6.69 |", "| 8 | 21.8 |", "| 16 | 27.4 |", "| 64 | 109 |")),
        ("benchmarks/results/soak.md", ("800 of 100 000", "5600 commands", "30 of 300")),
    ],
)
def test_numbers_are_those_of_their_page(name: str, rows: tuple[str, ...]) -> None:
    assert all(row in page(name) for row in rows)


@pytest.mark.soak
def test_oldest_and_newest_ran() -> None:
    assert page("benchmarks/results/matrix.md").count("298 passed") == 5


@pytest.mark.soak
def test_shapes_are_few() -> None:
    assert set(SHAPE_KINDS) == {"rod", "arrow", "ball", "box", "face"}


@pytest.mark.soak
def test_an_animation_needs_its_project() -> None:
    model = scaffold("wheel", Path()) / "generated" / "wheel"
    assert "cannot animate" in refusal(mehvar.simulate(str(model), "balance").mehvar.animate)


@pytest.mark.soak
def test_numbers_in_python_have_no_units() -> None:
    for name, given in (("t_end", "5s"), ("theta_0", "20deg")):
        said = refusal(lambda name=name, given=given: mehvar.simulate("triangle", "path", **{name: given}))  # type: ignore[misc]
        assert "must be a number" in said
    varied = mehvar.batch("triangle", "path", n=2, vary={"theta_0": "uniform(10deg, 20deg)"}, out="u.zarr")
    assert float(varied.theta_0.max()) < 0.35


@pytest.mark.soak
def test_constants_are_for_a_board_only() -> None:
    assert "--inline-parameters" in cli("board build --help")
    assert "--inline-parameters" not in cli("generate --help")
