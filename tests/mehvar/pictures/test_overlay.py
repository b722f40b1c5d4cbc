# SPDX-License-Identifier: Apache-2.0
"""Pictures of two versions show something, with readable numbers."""

import numpy as np
import pytest
import xarray as xr

from mehvar.pictures.overlay import effects_picture, overlay_picture
from mehvar.pictures.style import style

pytest.importorskip("matplotlib")
T = np.linspace(0.0, 1.0, 11)


def run(factor: float) -> xr.Dataset:
    return xr.Dataset({"v": ("t", factor * T)}, coords={"t": T})


def test_runs_without_a_visible_difference_have_no_picture():
    with style():
        assert overlay_picture(run(1.0), run(1.0 + 1e-6), "cart") is None
        figure = overlay_picture(run(1.0), run(1.5), "cart")
    assert [ax.get_ylabel() for ax in figure.axes] == ["v [1]"]


@pytest.mark.parametrize("change", [0.0, -6e-16, 1e-14, 1e-6, 1e-3, 0.5])
def test_ticks_of_eigenvalues_that_hardly_differ_are_short(change):
    pairs = [(complex(-0.12475, 7.993), complex(-0.12475 + change, 7.994))]
    with style():
        figure = effects_picture({}, [("eigenvalues", "1/s", pairs)])
        figure.canvas.draw()
    (ax,) = figure.axes
    ticks = [label.get_text() for label in ax.get_xticklabels()]
    assert len(ticks) > 1
    assert max(map(len, ticks)) < 9
