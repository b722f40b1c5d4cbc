# SPDX-License-Identifier: Apache-2.0
"""Model exchange, call by call: modes, instants of a sampled law, numbers of states; importers are tested as peers."""

from __future__ import annotations

import ctypes as c
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from mehvar.runtime import load
from tests.mehvar.fmu.test_cycles import unpacked

OK, ERROR = 0, 3


class Callbacks(c.Structure):
    """Callbacks of FMI 2; none is called here."""

    _fields_ = [(name, c.c_void_p) for name in ("logger", "allocate", "free", "finished", "environment")]


class EventInfo(c.Structure):
    """Discrete states of FMI 2."""

    _fields_ = [
        *((name, c.c_int) for name in ("needed", "terminate", "nominals", "values", "next_defined")),
        ("next", c.c_double),
    ]


class Unit:
    """A unit in model exchange, after its initialization; by default of the satellite under a sampled law."""

    def __init__(self, folder: Path, fmi: str, model: str = "satellite", law: str | None = "pd") -> None:
        token = unpacked(folder, model, controller=law, fmi=fmi).encode()
        (binary,) = (folder / "binaries").glob("*/*.so")
        self._library, self._fmi = c.CDLL(str(binary)), fmi[0]
        create = self._library[f"fmi{fmi[0]}Instantiate" + ("ModelExchange" if fmi[0] == "3" else "")]
        create.restype = c.c_void_p
        if fmi[0] == "3":
            self._instance = create(b"unit", token, b"", False, False, None, None)
        else:
            self._functions = Callbacks()
            self._instance = create(b"unit", 0, token, b"", c.byref(self._functions), 0, 0)
        assert self._instance
        if fmi[0] == "3":
            assert self("EnterInitializationMode", False, c.c_double(0), c.c_double(0), False, c.c_double(0)) == OK
        else:
            assert self("SetupExperiment", 0, c.c_double(0), c.c_double(0), 0, c.c_double(0)) == OK
            assert self("EnterInitializationMode") == OK
        assert self("ExitInitializationMode") == OK

    def __call__(self, name: str, *arguments: Any) -> int:
        return int(self._library[f"fmi{self._fmi}{name}"](c.c_void_p(self._instance), *arguments))

    def next_event(self) -> tuple[bool, float]:
        """Return whether the unit ends, and the instant of its next event, which it must have."""
        if self._fmi == "2":
            info = EventInfo()
            assert self("NewDiscreteStates", c.byref(info)) == OK
            assert info.next_defined
            return bool(info.terminate), info.next
        flags, instant = (c.c_bool * 5)(), c.c_double(-1.0)
        places = [c.byref(flags, k) for k in range(5)]
        assert self("UpdateDiscreteStates", *places, c.byref(instant)) == OK
        assert flags[4]
        return flags[1], instant.value


@pytest.mark.parametrize("fmi", ["2.0", "3.0"])
@pytest.mark.share(2)
def test_events_of_a_sampled_law_come_a_period_apart_and_modes_in_turn(tmp_path: Path, fmi: str) -> None:
    unit, model = Unit(tmp_path, fmi), load("satellite")
    period = next(p.default for p in model.manifest.parameters if p.name == "Ts")
    for k in range(1, 4):
        assert unit("EnterEventMode") == (ERROR if k == 1 else OK), "it begins in events"
        ends, instant = unit.next_event()
        assert not ends
        assert instant == pytest.approx(k * period)
        assert unit("EnterContinuousTimeMode") == OK
        assert unit("EnterContinuousTimeMode") == ERROR
        assert unit("SetTime", c.c_double(instant)) == OK


@pytest.mark.soak
def test_discrete_states_without_a_place_for_each_answer_are_refused(tmp_path: Path) -> None:
    unit, flags, instant = Unit(tmp_path, "3.0", "triangle", "path"), (c.c_bool * 5)(), c.c_double()
    places = [*(c.byref(flags, k) for k in range(5)), c.byref(instant)]
    for k in range(6):
        assert unit("UpdateDiscreteStates", *(None if i == k else place for i, place in enumerate(places))) == ERROR
    assert unit("UpdateDiscreteStates", *places) == OK


@pytest.mark.parametrize("fmi", ["2.0", "3.0"])
@pytest.mark.share(2)
def test_another_number_of_states_is_refused(tmp_path: Path, fmi: str) -> None:
    unit, n = Unit(tmp_path, fmi), len(load("satellite").state_names)
    unit.next_event()
    assert unit("EnterContinuousTimeMode") == OK
    for size in (n - 1, n, n + 1):
        values = (c.c_double * (n + 1))(*[7.0] * (n + 1))
        assert unit("GetNominalsOfContinuousStates", values, c.c_size_t(size)) == (OK if size == n else ERROR)
        assert list(values) == [1.0] * n + [7.0] if size == n else list(values) == [7.0] * (n + 1)
        for function in ("SetContinuousStates", "GetContinuousStates", "GetContinuousStateDerivatives"):
            name = "GetDerivatives" if fmi == "2.0" and function.endswith("Derivatives") else function
            assert unit(name, (c.c_double * (n + 1))(), c.c_size_t(size)) == (OK if size == n else ERROR)


@pytest.mark.soak
def test_derivatives_are_those_of_rates_and_outputs_and_of_nothing_else(tmp_path: Path) -> None:
    unit = Unit(tmp_path, "3.0", "triangle", None)
    structure = ElementTree.parse(tmp_path / "modelDescription.xml").find("ModelStructure")
    assert structure is not None
    rows = {
        int(row.attrib["valueReference"]) for row in structure if row.tag in ("Output", "ContinuousStateDerivative")
    }
    one, seed, known = c.c_size_t(1), c.c_double(1.0), c.c_uint(1)
    assert len(rows) > 1
    for reference in (*range(max(rows) + 9), 2**32 - 1):
        unknown, value = c.c_uint(reference), c.c_double(7.0)
        status = unit("GetDirectionalDerivative", c.byref(unknown), one, c.byref(known), one, c.byref(seed), one,
                      c.byref(value), one)  # fmt: skip
        assert (status == OK) == (reference in rows), reference
        assert (value.value == 7.0) or status == OK
