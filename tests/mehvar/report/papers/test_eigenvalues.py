# SPDX-License-Identifier: Apache-2.0
"""Eigenvalues of the loops in the report."""

import numpy as np
import pytest

import mehvar
from mehvar.report.papers.eigenvalues import SHOWN, loop_spectra
from mehvar.reproduction.runs import Runs


@pytest.mark.parametrize(("name", "law"), [("slosh", "lyapunov-v2"), ("satellite", "pd")])
def test_a_loop_is_linearised_where_its_run_ends(name, law):
    model = mehvar.load(name)
    runs, scenario = Runs(model), next(iter(model.manifest.scenarios))
    (spectrum,) = loop_spectra(runs, [(scenario, law)])
    run = runs(law, scenario)
    assert len(runs) == 1
    assert spectrum.t == run.t[-1]
    assert (spectrum.period is None) == (model.manifest.controller(law).period is None)
    measure = np.real if spectrum.period is None else np.abs
    sizes = measure(np.array(spectrum.nearest))
    assert len(sizes) == SHOWN <= spectrum.count
    assert np.all(np.diff(sizes) <= 0)
    assert np.array(spectrum.nearest).imag.min() >= 0
    assert sizes[0] < (0 if spectrum.period is None else 1.001)


@pytest.mark.parametrize("scenario", ["paper", "printed"])
def test_no_eigenvalues_where_rounding_decides_on_them(scenario):
    """The path law has a kink at its target, where K = 2 |theta| / rho^2 is 0/0."""
    (spectrum,) = loop_spectra(Runs(mehvar.load("triangle")), [(scenario, "path")])
    assert spectrum.nearest == ()
    assert spectrum.count == 4
