# SPDX-License-Identifier: Apache-2.0
"""Points that are given: grids of lists, tables, and what of them is refused."""

import numpy as np
import pandas as pd
import pytest

import mehvar
from mehvar.base.errors import InputError

FRAME = pd.DataFrame({"theta_0": [0.5, 1.0, 1.2], "l1_0": [0.2, 0.21, 0.22]})


def batch(**points):
    return mehvar.batch("triangle", "path", t_end=0.1, **points)


def test_a_grid_has_every_combination_and_each_run_is_a_run_of_its_own():
    runs = batch(vary={"theta_0": [0.5, 1.0], "l1_0": [0.2, 0.21, 0.22]}, design="grid")
    assert runs.theta_0.values.tolist() == [0.5, 0.5, 0.5, 1.0, 1.0, 1.0]
    assert runs.l1_0.values.tolist() == [0.2, 0.21, 0.22] * 2
    single = mehvar.simulate("triangle", "path", t_end=0.1, theta_0=1.0, l1_0=0.21)
    assert float(runs.max_rho[4]) == float(single.max_rho)


def test_a_table_has_a_row_for_each_run(tmp_path):
    FRAME.to_csv(tmp_path / "points.csv", index=False)
    frame, file, columns = (
        batch(points=points)
        for points in (FRAME, tmp_path / "points.csv", {name: FRAME[name].to_numpy() for name in FRAME})
    )
    for runs in (frame, file, columns):
        assert runs.theta_0.values.tolist() == FRAME.theta_0.tolist()
        assert runs.max_rho.values.tolist() == frame.max_rho.values.tolist()


def test_listed_values_may_have_units():
    runs = batch(vary={"theta_0": "values(50 deg, 0.9, 60 deg)"})
    np.testing.assert_allclose(runs.theta_0, [np.radians(50), 0.9, np.radians(60)], rtol=1e-15)


def test_own_points_stand_beside_drawn_ones():
    runs = batch(points=FRAME, vary={"R": "uniform(0.6, 0.65)"})
    assert runs.l1_0.values.tolist() == FRAME.l1_0.tolist()
    assert len(np.unique(runs.R)) == 3


@pytest.mark.parametrize(
    ("points", "why"),
    [
        ({"points": {"theta_0": []}}, "at least one row"),
        ({"points": 3}, "must be a CSV file, a pandas.DataFrame, or columns by name"),
        ({"points": {"thta_0": [1.0]}}, "did you mean theta_0"),
        (
            {"points": {"theta_0": [1.0, float("nan")]}},
            r"theta_0 = nan \(from the call, row 2\)",
        ),
        ({"points": {"theta_0": [1.0, 2.0], "l1_0": [0.2]}}, "n = 2"),
        ({"points": FRAME, "vary": {"theta_0": "uniform(0, 1)"}}, "theta_0 is given twice, in vary and in points"),
        ({"points": FRAME, "n": 5}, r"n = 5 \(from the call\): must be 3"),
        ({"points": FRAME, "vary": {"R": "uniform(0.6, 0.65)"}, "sampling": "saltelli"}, "saltelli combines values of"),
        ({"points": FRAME, "sampling": "latin"}, "sampling = 'latin' .*: must be left out unless values are drawn"),
        ({"points": FRAME, "seed": 9}, r"seed = 9 \(from the call\): must be left out unless values are drawn or the"),
        ({"vary": {"theta_0": "values(50 deg, 60 kg)"}}, "kg"),
        ({"design": "grid", "vary": {"theta_0": "uniform(0, 1)"}}, 'must be a list of values, since design = "grid"'),
        ({"design": "grid"}, "left out unless vary has lists"),
        ({"design": "latin", "vary": {"theta_0": [1.0]}}, 'must be "grid"; for drawn points use sampling'),
    ],
)
def test_what_is_no_design_is_refused(points, why):
    with pytest.raises(InputError, match=why):
        batch(**points)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        (None, "cannot be read as CSV: No such file"),
        ("", "cannot be read as CSV: No columns"),
        ("theta_0\n", "at least one row"),
        ("theta_0\n0.5\nfar\n", r"theta_0 = 'far' \(from .*points.csv, row 2\): must be a number"),
        ("theta_0,l1_0\n0.5,0.6,7\n", "must be a CSV file whose rows have as many cells as its first line has names"),
        ("theta_0,l1_0\n0.5,\n", r"l1_0 = nan \(from .*points.csv, row 1\): must be a finite number"),
    ],
)
def test_a_file_that_is_no_table_is_refused_with_its_place(text, why, tmp_path):
    file = tmp_path / "points.csv"
    if text is not None:
        file.write_text(text)
    with pytest.raises(InputError, match=why):
        batch(points=file)
