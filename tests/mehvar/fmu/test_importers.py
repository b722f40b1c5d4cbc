# SPDX-License-Identifier: Apache-2.0
"""FMUs as FMPy runs them: valid, our bits in co-simulation, our run in model exchange, wrong calls refused."""

from __future__ import annotations

import numpy as np
import pytest

import mehvar

pytestmark = pytest.mark.peers

BOUND = 1e-9
"""Bound for continuous loops, relative to the largest value of a state: the tolerance is 1e-11, and measured are
3.8e-10, for slosh."""

CASES = [("triangle", "path", 10.0, 0.125), ("satellite", "pd", 60.0, 0.5), ("slosh", "lyapunov-v1", 20.0, 0.25)]


def simulated(path, run, step, **options):
    import fmpy
    from fmpy.validation import validate_fmu

    assert validate_fmu(str(path)) == []
    about = fmpy.read_model_description(str(path))
    known = {variable.name for variable in about.modelVariables}
    names = [name for name in mehvar.load(run.attrs["model"]).state_names if name in known]
    result = fmpy.simulate_fmu(
        str(path), stop_time=float(run["t"][-1]), output_interval=step, output=names, **options
    )  # fmt: skip
    return names, result


@pytest.mark.parametrize("fmi", ["2.0", "3.0"])
@pytest.mark.parametrize(("model", "law", "end", "step"), CASES)
def test_co_simulation_is_our_run(model, law, end, step, fmi, tmp_path):
    """Sampled laws bit for bit; a continuous loop is within its tolerance of ours, which passes over samples."""
    pytest.importorskip("fmpy.validation", reason="make peers installs it")
    path = tmp_path / "unit.fmu"
    mehvar.export_fmu(model, path, controller=law, fmi=fmi, kind="cs")
    run = mehvar.simulate(model, law, t_end=end, dt_out=step)
    names, result = simulated(path, run, step)
    for name in names:
        scale = 0.0 if mehvar.load(model).manifest.controller(law).period else max(1.0, float(np.abs(run[name]).max()))
        np.testing.assert_allclose(result[name], run[name].values, rtol=0, atol=BOUND * scale, err_msg=name)


@pytest.mark.parametrize("fmi", ["2.0", "3.0"])
@pytest.mark.parametrize(("model", "law", "end", "step"), CASES)
def test_model_exchange_is_our_run(model, law, end, step, fmi, tmp_path):
    pytest.importorskip("fmpy.validation", reason="make peers installs it")
    path = tmp_path / "unit.fmu"
    mehvar.export_fmu(model, path, controller=law, fmi=fmi, kind="me")
    run = mehvar.simulate(model, law, t_end=end, dt_out=step)
    names, result = simulated(path, run, step, relative_tolerance=1e-10)
    for name in names:
        rows = [np.flatnonzero(np.isclose(result["time"], t, rtol=0, atol=1e-9))[0] for t in run["t"].values]
        scale = max(1.0, float(np.abs(run[name]).max()))
        np.testing.assert_allclose(np.asarray(result[name])[rows], run[name], atol=1e-6 * scale, err_msg=name)


@pytest.fixture
def unit(tmp_path):
    fmpy = pytest.importorskip("fmpy", reason="make peers installs it")
    from fmpy.fmi2 import FMU2Slave

    path = tmp_path / "unit.fmu"
    mehvar.export_fmu("triangle", path, controller="path", fmi="2.0", kind="cs")
    about = fmpy.read_model_description(str(path))
    folder = fmpy.extract(str(path), str(tmp_path / "unit"))
    slave = FMU2Slave(guid=about.guid, unzipDirectory=folder, modelIdentifier=about.coSimulation.modelIdentifier)
    slave.instantiate()
    return slave


def started(slave, stop=10.0):
    slave.setupExperiment(startTime=0.0, stopTime=stop)
    slave.enterInitializationMode()
    slave.exitInitializationMode()


def test_wrong_calls_are_answered(unit):
    from fmpy.fmi1 import FMICallException

    with pytest.raises(FMICallException):
        unit.doStep(0.0, 0.1)
    started(unit)
    for t, h in ((0.0, -0.1), (0.0, 0.0), (0.0, 10.5), (1.0, 0.1), (0.0, float("nan"))):
        with pytest.raises(FMICallException):
            unit.doStep(t, h)
    with pytest.raises(FMICallException):
        unit.getReal([100_000])
    with pytest.raises(FMICallException):
        unit.setReal([1], [2.0])
    unit.doStep(0.0, 0.1)


def test_a_state_comes_back(unit):
    """Saved as bytes, restored, and gone on from: the same numbers as without."""
    started(unit)
    outputs = list(range(30))
    unit.doStep(0.0, 0.1)
    state = unit.getFMUstate()
    kept = unit.serializeFMUstate(state)
    unit.doStep(0.1, 0.1)
    expected = unit.getReal(outputs)
    unit.doStep(0.2, 0.1)
    restored = unit.deSerializeFMUstate(kept)
    unit.setFMUstate(restored)
    unit.doStep(0.1, 0.1)
    assert unit.getReal(outputs) == expected
    unit.freeFMUstate(state)
    unit.freeFMUstate(restored)


def test_reset_begins_anew(unit):
    results = []
    for _ in range(50):
        started(unit)
        unit.doStep(0.0, 0.1)
        results.append(unit.getReal(list(range(30))))
        unit.reset()
    assert all(result == results[0] for result in results)
