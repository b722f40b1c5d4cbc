# SPDX-License-Identifier: Apache-2.0
"""A parameter that a run does not read is refused, and no other is: what is refused would not change a bit."""

from __future__ import annotations

import random
import re
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mehvar
from mehvar import runtime
from mehvar.base.errors import InputError
from mehvar.base.manifest import OPEN_LOOP, Controller, Manifest
from mehvar.base.names import identifier
from mehvar.runtime.run import simulate
from mehvar.runtime.run.readers import check_read
from mehvar.runtime.run.user.law import describe
from tests.fuzz.campaign import in_process

PENDULUM = str(Path(__file__).parents[1] / "pendulum")
MODELS = ["triangle", "satellite", PENDULUM]
ROLES = {"rhs", "outputs", "limits", "actuate", "measure", "reference", "initial"}
SHORT: dict[str, Any] = {"t_end": 0.2, "dt_out": 0.1, "method": "rk4", "step": 0.1}


def numbers(model: str, law: Any, **arguments: Any) -> bytes:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        run = runtime.simulate(model, law, **SHORT, **arguments)
    return b"".join(series.tobytes() for series in run.variables().values())


def others(manifest: Manifest, law: Controller, names: list[str]) -> dict[str, float]:
    """Return other values than a run has by default: near them, within the bounds."""
    rows = {q.name: q for q in (*manifest.parameters, *law.parameters, *manifest.scenario_parameters)}
    values = manifest.scenario(None).values
    result = {}
    for name in names:
        q = rows[name]
        now = values.get(name, q.default if q.default is not None else 1.0)
        result[name] = next(v for v in (now * 1.01 + 1e-3, now * 0.99 - 1e-3, now * 0.99) if q.allows(v) and v != now)
    return result


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.share(2)
def test_what_is_refused_would_not_change_a_bit_of_the_run(model, monkeypatch):
    manifest, pick, count = runtime.load(model).manifest, random.Random(15), 0
    monkeypatch.setattr(simulate, "check_read", lambda *_: None)
    for law in manifest.controllers.values():
        names = [q.name for q in (*manifest.parameters, *law.parameters, *manifest.scenario_parameters)]
        for _ in range(12):
            start = runtime.load(model).functions["initial"](*_vectors(model))
            states = dict(zip([q.name for q in manifest.states], map(float, start), strict=True))
            initial = {name: value for name, value in states.items() if pick.random() < 0.5}
            given = others(manifest, law, pick.sample(names, 3))
            refused = unread(manifest, law, given, initial)
            count += len(refused)
            rest = {name: value for name, value in given.items() if name not in refused}
            try:
                whole = numbers(model, law.name, parameters=given, initial=initial)
            except InputError:  # values that do not go together
                continue
            assert whole == numbers(model, law.name, parameters=rest, initial=initial), (law.name, given, initial)
    assert count


def _vectors(model: str) -> tuple[Any, Any]:
    resolved = runtime.simulate(model, next(iter(runtime.load(model).manifest.controllers)), **SHORT).parameters
    return resolved.p, resolved.s


def unread(manifest: Manifest, law: Controller, given: dict[str, float], initial: dict[str, float]) -> set[str]:
    try:
        check_read(manifest, law, "", law.period is not None, given, initial, "test")
    except InputError as error:
        return {line.split(" = ")[0] for line in str(error).splitlines()}
    return set()


@pytest.mark.parametrize("model", MODELS)
def test_a_function_changes_with_its_parameters_only(model):
    """A function reads each parameter that changes it: the manifest's readers are not too few."""
    loaded = runtime.load(model)
    manifest, random_numbers = loaded.manifest, np.random.default_rng(16)
    groups = {"p": manifest.parameters, "s": manifest.scenario_parameters}
    for law in manifest.controllers.values():
        for name, function in loaded.functions.items():
            own = name_of_law(manifest, identifier(name)) == law.name
            words = set(identifier(name).split("_"))
            if function.function.internal:
                continue
            if not (own or words & ROLES) or words & {"jac", "jvp", "constraints", "warnings", "value", "demand"}:
                continue
            arguments = [random_numbers.uniform(0.1, 0.9, a.shape) for a in function.function.arguments]
            for place, array in enumerate(function.function.arguments):
                rows = groups.get(array.name, law.parameters if array.name == "c" and own else ())
                for k, q in enumerate(rows):
                    changed = [a.copy() for a in arguments]
                    changed[place][k] *= 1.1
                    with np.errstate(all="ignore"):
                        old, new = (np.hstack([np.ravel(v) for v in _all(function(*a))]) for a in (arguments, changed))
                    if not np.array_equal(old, new, equal_nan=True):
                        readers = {reader.partition(".")[0] for reader in q.readers}
                        assert identifier(name) in readers, (name, q.name)


def name_of_law(manifest: Manifest, function: str) -> str:
    laws = [law for law in manifest.controllers if f"{function}_".startswith(f"{identifier(law)}_")]
    return max(laws, key=len, default="")


def _all(result: Any) -> tuple[Any, ...]:
    return result if isinstance(result, tuple) else (result,)


REFUSED = r"angle_0 = .*: must be left out: here it only determines angle, which is given too: give one of them"


def test_what_a_given_start_overrides_is_refused_everywhere(tmp_path):
    with pytest.raises(InputError, match=REFUSED):
        mehvar.simulate(PENDULUM, "pd", initial={"angle": 0.1}, angle_0=0.2)
    with pytest.raises(InputError, match=REFUSED):
        mehvar.batch(PENDULUM, "pd", 2, vary={"angle_0": "normal(0.2, 0.1)"}, initial={"angle": 0.1})
    with pytest.raises(InputError, match=REFUSED):
        mehvar.batch(PENDULUM, "pd", 2, vary={"angle_0": "normal(0.2, 0.1)", "angle": "normal(0.2, 0.1)"})
    file = tmp_path / "campaign.toml"
    file.write_text(
        f"model = '{PENDULUM}'\ncontroller = 'pd'\nn = 2\n[vary]\nangle_0 = 'normal(0, 1)'\nangle = 'normal(0, 1)'"
    )
    with pytest.raises(InputError, match=REFUSED):
        mehvar.batch(file)
    line = (
        "batch",
        PENDULUM,
        "--out",
        str(tmp_path / "s.zarr"),
        "--controller",
        "pd",
        "-n",
        "2",
        "--set",
        "angle_0=0.2",
        "--vary",
        "angle=normal(0, 1)",
    )
    status, text = in_process(*line)
    assert status == 2
    assert re.search(REFUSED, text)


def test_a_start_that_is_given_in_part_leaves_the_rest_to_its_parameters():
    assert numbers(PENDULUM, "pd", initial={"rate": 0.1}, angle_0=0.2) != numbers(
        PENDULUM, "pd", initial={"rate": 0.1}, angle_0=0.3
    )


def test_a_parameter_of_another_law_is_refused_and_of_the_own_one_not():
    with pytest.raises(InputError, match=r"Ts = 0.1 .*: must be left out: no function of a run under pd reads it"):
        mehvar.simulate(PENDULUM, "pd", Ts=0.1)
    mehvar.simulate(PENDULUM, "p-sum", t_end=0.2, Ts=0.1, dt_out=0.1)


def test_a_parameter_behind_a_formula_is_refused_where_the_formula_is_overridden():
    manifest = runtime.load(PENDULUM).manifest
    law = manifest.controllers["pd"]
    k_p, k_d = law.parameters
    law = replace(law, parameters=(replace(k_p, readers=("pd_defaults.k_d",)), k_d))
    check_read(manifest, law, "", False, {"k_p": 1.0}, (), "test")
    with pytest.raises(InputError, match=r"k_p = 1.0 .*: here it only determines k_d, which is given too"):
        check_read(manifest, law, "", False, {"k_p": 1.0, "k_d": 1.0}, (), "test")


def test_a_reference_is_read_by_what_takes_it_and_by_a_law_in_python():
    manifest = runtime.load(PENDULUM).manifest
    rows = tuple(replace(q, readers=("reference", "pd", "pd_loop")) for q in manifest.scenario_parameters)
    manifest = replace(manifest, scenario_parameters=rows)
    check_read(manifest, describe("python:f", ""), "", True, {"angle_ref": 1.0}, (), "test")
    check_read(manifest, manifest.controllers["pd"], "", False, {"angle_ref": 1.0}, (), "test")
    with pytest.raises(InputError, match=r"angle_ref = 1.0 .*no function of a run under none reads it"):
        check_read(manifest, describe(OPEN_LOOP, ""), "", True, {"angle_ref": 1.0}, (), "test")
