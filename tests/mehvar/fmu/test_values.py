# SPDX-License-Identifier: Apache-2.0
"""The values of an FMU through its C functions: those of our runs from initialization on, or refused as there."""

from __future__ import annotations

import ctypes
import zipfile
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import casadi as ca
import numpy as np
import pytest

import mehvar
from mehvar.fmu.description import Version, description
from mehvar.fmu.variables import subject

_LOGGER = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 2, ctypes.c_int, *[ctypes.c_char_p] * 2)
ERROR = 3
IDLE = {"Ts", "umax", "noise", "noise_rate", "quantum"}
"""Parameters of the satellite that act on samples alone."""


class Unit:
    """An instance of an FMU by FMI 2.0 for co-simulation; `said` has what it logged."""

    def __init__(self, folder: Path, model: str, controller: str | None) -> None:
        mehvar.export_fmu(model, folder / "unit.fmu", controller=controller)
        with zipfile.ZipFile(folder / "unit.fmu") as archive:
            archive.extractall(folder)
        about = ElementTree.parse(folder / "modelDescription.xml").getroot()
        self.about, variables = about, about.find("ModelVariables")
        assert variables is not None
        self.places = {str(v.get("name")): k for k, v in enumerate(variables)}
        self.said: list[str] = []
        self._logger = _LOGGER(lambda _e, _n, _s, _c, text: self.said.append((text or b"").decode()))
        self._functions = (ctypes.c_void_p * 5)(ctypes.cast(self._logger, ctypes.c_void_p))
        self.library = ctypes.CDLL(str(next((folder / "binaries" / "linux64").iterdir())))
        self.library.fmi2Instantiate.restype = ctypes.c_void_p
        token = str(about.get("guid")).encode()
        arguments = (b"unit", 1, token, b"", ctypes.byref(self._functions), 0, 0)
        self._instance = ctypes.c_void_p(self.library.fmi2Instantiate(*arguments))

    def begin(self, **values: float) -> int:
        """Initialize with values by name, whose dots are two underscores; return the status."""
        self.library.fmi2Reset(self._instance)
        zero = ctypes.c_double(0.0)
        self.library.fmi2SetupExperiment(self._instance, 0, zero, zero, 0, zero)
        self.library.fmi2EnterInitializationMode(self._instance)
        for name, value in values.items():
            self.set(name.replace("__", "."), value)
        return int(self.library.fmi2ExitInitializationMode(self._instance))

    def set(self, name: str, value: float) -> None:
        place = (ctypes.c_uint * 1)(self.places[name])
        assert self.library.fmi2SetReal(self._instance, place, 1, (ctypes.c_double * 1)(value)) == 0

    def get(self, *names: str) -> list[float]:
        values = (ctypes.c_double * len(names))()
        places = (ctypes.c_uint * len(names))(*(self.places[name] for name in names))
        assert self.library.fmi2GetReal(self._instance, places, len(names), values) == 0
        return list(values)

    def along(self, known: str, *unknowns: str) -> list[float]:
        """Return the derivatives of variables with respect to another one."""
        values = (ctypes.c_double * len(unknowns))()
        places = (ctypes.c_uint * len(unknowns))(*(self.places[name] for name in unknowns))
        by, one = (ctypes.c_uint * 1)(self.places[known]), (ctypes.c_double * 1)(1.0)
        call = self.library.fmi2GetDirectionalDerivative
        assert call(self._instance, places, len(unknowns), by, 1, one, values) == 0
        return list(values)

    def step(self, t: float, h: float) -> None:
        assert self.library.fmi2DoStep(self._instance, ctypes.c_double(t), ctypes.c_double(h), 1) == 0


@pytest.fixture(scope="module")
def sampled(tmp_path_factory: pytest.TempPathFactory) -> Unit:
    return Unit(tmp_path_factory.mktemp("unit"), "satellite", "pd")


@pytest.fixture(scope="module")
def continuous(tmp_path_factory: pytest.TempPathFactory) -> Unit:
    return Unit(tmp_path_factory.mktemp("unit"), "triangle", "path")


def names_of(model: str, run: Any) -> list[str]:
    """Return states, inputs and outputs of a model."""
    manifest = mehvar.load(model).manifest
    return [*(q.name for q in (*manifest.states, *manifest.outputs)), *(f"u_{q.name}" for q in manifest.inputs)]


@pytest.mark.parametrize("step", [0.125, 0.5, 1.5])
def test_every_value_of_a_sampled_loop_has_our_bits_from_the_start_on(sampled: Unit, step: float) -> None:
    """At communication points within a period, at each sample, and every third one."""
    run = mehvar.simulate("satellite", "pd", t_end=6.0, dt_out=step)
    names = names_of("satellite", run)
    assert sampled.begin() == 0
    for k, t in enumerate(run["t"].values):
        np.testing.assert_array_equal(sampled.get(*names), [run[name].values[k] for name in names], str(t))
        if t < 6.0:
            sampled.step(t, step)


def test_values_are_there_before_initialization_ends(sampled: Unit) -> None:
    run = mehvar.simulate("satellite", "pd", t_end=0.5)
    names = names_of("satellite", run)
    sampled.library.fmi2Reset(sampled._instance)
    np.testing.assert_array_equal(sampled.get(*names), [run[name].values[0] for name in names])


def test_one_step_of_a_continuous_loop_is_a_run_of_ours(continuous: Unit) -> None:
    for end in (0.125, 1.0, 10.0):
        run = mehvar.simulate("triangle", "path", t_end=end, dt_out=end)
        assert continuous.begin() == 0
        continuous.step(0.0, end)
        states = mehvar.load("triangle").state_names
        np.testing.assert_array_equal(continuous.get(*states), [run[name].values[-1] for name in states])


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"plant__I_x": -1.0}, "plant.I_x = -1: must be in (0, inf) kg m^2"),
        ({"plant__I_x": 10.0}, "I_x = 10, I_y = 3.04, I_z = 3.09 kg m^2 are the inertias of no body"),
        ({"plant__wheels": 2.0}, "plant.wheels = 2: must be in [0, 1]"),
        ({"law__design_delay": 0.5}, "design_delay = 0.5 samples is not known"),
        ({"plant__Ts": 201.0}, "half_period = 200 s"),
        ({"roll": np.nan}, "not a finite number"),
        ({"reference__ref_roll": np.inf}, "not a finite number"),
    ],
)
def test_what_no_run_of_ours_takes_is_refused_with_a_message(sampled: Unit, values: Any, message: str) -> None:
    sampled.said.clear()
    assert sampled.begin(**values) == ERROR
    assert message in sampled.said[-1]
    assert sampled.begin() == 0


def test_conditions_on_the_scenario_are_those_of_its_start(continuous: Unit) -> None:
    assert continuous.begin(law__R=0.4) == ERROR
    assert "R = 0.4 must be larger than rho_f" in continuous.said[-1]
    assert continuous.begin(law__R=0.4, reference__rho_ref=0.2) == 0


@pytest.mark.soak
def test_every_announced_derivative_is_there(tmp_path: Path) -> None:
    """By CasADi, which asks for rates and outputs by states, inputs and parameters."""
    mehvar.export_fmu("satellite", tmp_path / "unit.fmu", kind="me")
    with zipfile.ZipFile(tmp_path / "unit.fmu") as archive:
        archive.extractall(tmp_path)
    builder, model = ca.DaeBuilder("unit", str(tmp_path)), mehvar.load("satellite")
    values = builder.create("values", ["x", "u"], ["ode", "y"])
    x, u = model.state(wx=0.01, roll=0.2, pitch=-0.1, hy=0.3), [0.1, -0.2, 0.3]
    p, r = model.parameters(), np.array([0.1, 0.2, -0.1])
    given = dict(zip([f"reference.{q.name}" for q in model.manifest.references], r, strict=True))
    given |= dict(zip(model.input_names, u, strict=True))
    inputs = [given[name] for name in builder.u()]
    jacobian = values.jacobian()(x, inputs, 0, 0)
    j_x, j_u, _ = model.functions["outputs_jac"](x, u, r, p)
    expected = {
        (0, 0): model.functions["jac_x"](x, u, p),
        (0, 1): model.functions["jac_u"](x, u, p),
        (1, 0): j_x,
        (1, 1): j_u,
    }
    free = [name in model.input_names for name in builder.u()]
    for (row, column), matrix in expected.items():
        part = jacobian[2 * row + column].full()
        part = part[:, free] if column else part
        np.testing.assert_allclose(part.ravel(), np.asarray(matrix).ravel(), 1e-12, 1e-18, err_msg=str((row, column)))


@pytest.mark.soak
def test_derivatives_by_parameters_and_references_are_the_generated_ones(tmp_path: Path) -> None:
    unit, model = Unit(tmp_path, "satellite", None), mehvar.load("satellite")
    assert unit.begin(roll=0.2, wx=0.01) == 0
    x, u, r, p = (
        unit.get(*names)
        for names in (
            model.state_names,
            model.input_names,
            [f"reference.{q.name}" for q in model.manifest.references],
            [f"plant.{q.name}" for q in model.manifest.parameters],
        )
    )
    rates, outputs = [f"der({name})" for name in model.state_names], [q.name for q in model.manifest.outputs]
    acting = [q.name not in IDLE for q in model.manifest.parameters]
    by_p = [unit.along(f"plant.{q.name}", *rates, *outputs) for q in model.manifest.parameters if q.name not in IDLE]
    by_r = [unit.along(f"reference.{q.name}", *rates, *outputs) for q in model.manifest.references]
    jac_p, jac_r = (
        np.reshape(model.functions[name](*a), (len(n), -1))
        for name, a, n in (("jac_p", (x, u, p), rates), ("outputs_jac_p", (x, u, r, p), outputs))
    )
    full = np.vstack([jac_p, jac_r])
    np.testing.assert_allclose(np.transpose(by_p), full[:, acting], 1e-12, 1e-18)
    assert not full[:, np.logical_not(acting)].any()
    j_r = np.reshape(model.functions["outputs_jac"](x, u, r, p)[2], (len(outputs), -1))
    np.testing.assert_allclose(np.transpose(by_r), np.vstack([np.zeros((len(rates), len(r))), j_r]), 1e-12)


@pytest.mark.parametrize("fmi", ["2.0", "3.0"])
def test_what_has_no_effect_is_a_constant(fmi: Version) -> None:
    """Noise and delay are not included, and neither is what a plant without its law does not use."""
    for law, idle in (("pd", {"plant.noise", "plant.noise_rate", "law.delay"}), (None, {f"plant.{n}" for n in IDLE})):
        root = ElementTree.fromstring(description(subject(mehvar.load("satellite"), law, None), fmi, "cs", "unit", ""))
        variables = list(root.find("ModelVariables") or ())
        constant = {v.get("name"): v for v in variables if v.get("variability") == "constant"}
        assert constant.keys() == idle
        assert all("without effect in this FMU" in str(v.get("description")) for v in constant.values())


def test_a_constant_cannot_be_set(sampled: Unit) -> None:
    sampled.begin()
    sampled.library.fmi2Reset(sampled._instance)
    place = (ctypes.c_uint * 1)(sampled.places["law.delay"])
    assert sampled.library.fmi2SetReal(sampled._instance, place, 1, (ctypes.c_double * 1)(1.0)) == ERROR
    assert sampled.get("law.delay") == [0.0]


def test_derivatives_of_a_loop_are_those_of_its_values(sampled: Unit, continuous: Unit) -> None:
    """In initialization, by all that can be set there; of a sampled law by way of its memory and its command."""
    for unit, model in ((sampled, "satellite"), (continuous, "triangle")):
        assert unit.begin() == 0
        unit.library.fmi2Reset(unit._instance)
        about = list(unit.about.find("ModelVariables") or [])
        names = {str(v.get("name")): v for v in about}
        groups = ("plant.", "law.", "reference.")
        settable = {name: v for name, v in names.items() if v.get("variability") != "constant"}
        knowns = [name for name, v in settable.items() if name.startswith(groups) or v.get("initial") == "exact"]
        unknowns = [name for name, v in names.items() if v.get("causality") == "output" or name.startswith("der(")]
        assert {f"u_{q}" for q in mehvar.load(model).input_names} < set(unknowns)
        smooth = 0
        for known in knowns:
            (value,), here = unit.get(known), np.array(unit.get(*unknowns))
            step = 1e-6 * max(1.0, abs(value))
            unit.set(known, value + step)
            after = (np.array(unit.get(*unknowns)) - here) / step
            unit.set(known, value - step)
            before = (here - np.array(unit.get(*unknowns))) / step
            unit.set(known, value)
            scale = np.abs(here) + np.abs(after) + 1e-3
            if (np.abs(after - before) < 1e-3 * scale).all():  # no kink
                smooth += 1
                misfit = np.abs(np.array(unit.along(known, *unknowns)) - (after + before) / 2) / scale
                assert misfit.max() < 2e-5, (known, unknowns[int(misfit.argmax())], misfit.max())
        assert smooth > 0.9 * len(knowns)


def test_a_held_command_does_not_change_with_the_states(sampled: Unit) -> None:
    """Between two samples; at one the command follows them."""
    assert sampled.begin() == 0
    sampled.step(0.0, 0.125)
    assert sampled.along("wx", "u_Tx") == [0.0]
    for k in range(1, 4):
        sampled.step(0.125 * k, 0.125)
    assert sampled.along("wx", "u_Tx") != [0.0]
