# SPDX-License-Identifier: Apache-2.0
"""Models: names, vectors, functions on both backends, what is refused."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mehvar
from mehvar import runtime
from mehvar.base.manifest import FILE, read_manifest
from mehvar.runtime import InputError, Model
from mehvar.runtime.model.catalogue import find_model
from mehvar.runtime.model.functions import BackendName
from tests.manifests import write_manifest

BACKENDS = ["c", "python"]
Edit = Callable[[str, str, str], Path]


@pytest.fixture(params=BACKENDS)
def model(request: pytest.FixtureRequest, pendulum: Model, slow_pendulum: Model) -> Model:
    return pendulum if request.param == "c" else slow_pendulum


def test_names_and_vectors(model: Model) -> None:
    assert model.state_names == ("angle", "rate")
    assert model.input_names == ("torque",)
    assert model.output_names == ("energy", "angle_error", "power")
    assert model.parameter_names[:4] == ("m", "l", "g", "b")
    np.testing.assert_array_equal(model.parameters(l=2.0)[:4], [1.0, 2.0, 9.81, 0.1])
    np.testing.assert_array_equal(model.state(rate=3), [0.0, 3.0])


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"mas": 1.0}, "unknown parameter 'mas' of pendulum"),
        ({"rate_mx": 1.0}, "did you mean rate_max"),
        ({"m": 0.0}, r"m = 0.0: must be in \(0, inf\) kg"),
        ({"g": -1.0}, r"g = -1.0: must be in \[0, inf\) m/s"),
        ({"m": float("nan")}, "m = nan: must be a finite number"),
        ({"m": "heavy"}, "m = 'heavy': must be a number"),
    ],
)
def test_bad_parameters(model: Model, values: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        model.parameters(**values)


def test_bad_states(model: Model) -> None:
    with pytest.raises(InputError, match=r"unknown state 'angel' of pendulum: did you mean angle\?"):
        model.state(angel=1.0)
    with pytest.raises(InputError, match="rate = inf: must be a finite number"):
        model.state(rate=float("inf"))


def test_rhs_by_hand(model: Model) -> None:
    p = model.parameters(m=2.0, l=0.5, b=0.3)
    expected = [0.7, (1.5 - 0.3 * 0.7 - 2.0 * 9.81 * 0.5 * np.sin(0.4)) / (2.0 * 0.25)]
    np.testing.assert_allclose(model.rhs([0.4, 0.7], [1.5], p), expected, rtol=1e-14)


def test_leading_axes_broadcast(model: Model) -> None:
    rng = np.random.default_rng(1)
    x, u, p = rng.normal(size=(4, 1, 2)), rng.normal(size=(3, 1)), model.parameters()
    result = model.rhs(x, u, p)
    assert result.shape == (4, 3, 2)
    one = np.array([[model.rhs(x[i, 0], u[j], p) for j in range(3)] for i in range(4)])
    np.testing.assert_array_equal(result, one)
    assert model.rhs(np.empty((0, 2)), [0.0], p).shape == (0, 2)
    assert model.jac_x(x, u, p).shape == (4, 3, 2, 2)
    assert model.jac_u(x, u, p).shape == (4, 3, 2, 1)


def test_any_memory_layout(model: Model) -> None:
    x = np.random.default_rng(2).normal(size=(6, 2))
    p, u = model.parameters(), [0.2]
    expected = model.rhs(x, u, p)
    np.testing.assert_array_equal(model.rhs(np.asfortranarray(x), u, p), expected)
    np.testing.assert_array_equal(model.rhs(x[::-1], u, p), expected[::-1])
    np.testing.assert_array_equal(model.rhs(np.repeat(x, 2, axis=0)[::2], u, p), expected)
    np.testing.assert_allclose(model.rhs(x.astype(np.float32), u, p), expected, rtol=1e-5)
    packed = np.zeros(6, dtype=[("flag", "u1"), ("x", "f8", 2)])
    packed["x"] = x
    np.testing.assert_array_equal(model.rhs(packed["x"], u, p), expected)


def test_scalar_functions(model: Model) -> None:
    swing = model.functions["swing"]
    period, omega = swing(2.0, 8.0)
    assert (period, omega) == (pytest.approx(np.pi), 2.0)
    periods, omegas = swing([[1.0], [4.0]], np.array([4, 16, 64]))
    assert periods.shape == omegas.shape == (2, 3)
    np.testing.assert_allclose(omegas[1], [1.0, 2.0, 4.0])
    assert repr(swing) == "swing(l, g) -> period, omega"


def test_laws_are_functions_under_their_names(model: Model) -> None:
    u, z_next = model.functions["p-sum"]([1.0, 0.0], [0.5], [0.0], [0.25], model.parameters(), [2.0, 4.0])
    np.testing.assert_allclose(u, [-2.0])
    np.testing.assert_allclose(z_next, [0.75])
    assert model.functions["p_sum"] is model.functions["p-sum"]
    assert "p-sum" in list(model.functions)
    with pytest.raises(KeyError, match="did you mean swing"):
        model.functions["swin"]


def test_nan_passes_through(model: Model) -> None:
    result = model.rhs([[np.nan, 0.0], [0.0, 1.0]], [0.0], model.parameters())
    assert np.isnan(result[0, 1])
    assert np.all(np.isfinite(result[1]))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([1.0, 2.0, 3.0], [0.0]), r"rhs: x must have the shape \(\.\.\., 2\), got \(3,\)"),
        ((1.0, [0.0]), r"rhs: x must have the shape \(\.\.\., 2\), got \(\)"),
        ((["a", "b"], [0.0]), "rhs: x must hold real numbers"),
        (([1.0, 2.0j], [0.0]), "rhs: x must hold real numbers, got complex128"),
        (([[1.0], [1.0, 2.0]], [0.0]), "rhs: x must be an array of numbers"),
        (([None, 1.0], ["0"]), "rhs: (x|u) must"),
        ((np.zeros((3, 2)), np.zeros((4, 1))), "leading axes must broadcast"),
    ],
)
def test_bad_arguments(model: Model, arguments: tuple[Any, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        model.rhs(*arguments, model.parameters())


def test_wrong_number_of_arguments(model: Model) -> None:
    with pytest.raises(InputError, match=r"rhs\(x\[2\], u\[1\], p\[10\]\) -> dx\[2\] takes 3 arguments, got 1"):
        model.functions["rhs"]([0.0, 0.0])


def test_backends_agree_on_every_function(pendulum: Model, slow_pendulum: Model) -> None:
    rng = np.random.default_rng(3)
    for name, function in pendulum.manifest.functions.items():
        arguments = [rng.uniform(0.1, 1.0, size=(5, *a.shape)) for a in function.arguments]
        fast, slow = pendulum.functions[name](*arguments), slow_pendulum.functions[name](*arguments)
        several = len(function.results) > 1
        for a, b in zip(fast, slow, strict=True) if several else [(fast, slow)]:
            np.testing.assert_allclose(a, b, rtol=1e-13, err_msg=name)


def test_jacobians_against_differences(model: Model) -> None:
    p, u, x = model.parameters(cube=0.3, k_wall=0.2, wall=5.0), np.array([0.4]), np.array([0.7, -0.2])
    h = 1e-6
    rows = [(model.rhs(x + h * e, u, p) - model.rhs(x - h * e, u, p)) / (2 * h) for e in np.eye(2)]
    np.testing.assert_allclose(model.jac_x(x, u, p), np.transpose(rows), atol=1e-8)
    column = (model.rhs(x, u + h, p) - model.rhs(x, u - h, p)) / (2 * h)
    np.testing.assert_allclose(model.jac_u(x, u, p)[:, 0], column, atol=1e-8)


def test_models_are_found_by_folder_only_if_they_are_one(folder: Path, tmp_path: Path) -> None:
    assert find_model(str(folder)).model == "pendulum"
    assert find_model(folder).scenarios["stiff"].values == {"angle_0": 0.8, "k_p": 30.0}
    with pytest.raises(InputError, match="is not a generated model folder"):
        find_model(tmp_path)
    with pytest.raises(InputError, match="unknown model"):
        find_model("no-such-model")
    with pytest.raises(InputError, match="backend = 'fortran': must be 'c', 'python' or 'casadi'"):
        runtime.load(folder, backend="fortran")  # type: ignore[arg-type]


@pytest.fixture
def project(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    shutil.copytree(folder, tmp_path / "generated" / "pendulum")
    (tmp_path / "models" / "pendulum").mkdir(parents=True)
    (tmp_path / "models" / "pendulum" / "parameters.toml").touch()
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_models_of_the_project_are_known_and_suggested(project: Path) -> None:
    assert find_model("pendulum").folder == project / "generated" / "pendulum"
    with pytest.raises(InputError, match=r"'pendlum' .*: did you mean pendulum\? known: .*, pendulum"):
        find_model("pendlum")


@pytest.mark.parametrize("name", ["", ".", "..", "pendulum/", "../generated/pendulum", "pendulum\0", "p" * 5000])
def test_a_name_is_no_path_below_generated(project: Path, name: str) -> None:
    with pytest.raises(InputError):
        find_model(name)


def test_a_model_of_the_project_hides_the_one_of_its_name(project: Path) -> None:
    (project / "generated" / "pendulum").rename(project / "generated" / "triangle")
    with pytest.warns(UserWarning, match="triangle: using the model in .*, not mehvar's model of this name"):
        assert find_model("triangle").model == "pendulum"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"schema": 1', '"schema": 99', "schema = 99: must be 1; generate the model again"),
        ('"model": "pendulum"', '"modell": "p"', "json: modell is not known; generate the"),
        (
            '"duration": 2.0',
            '"duration": "long"',
            r"json: scenarios.swing.duration = 'long': must be a number; generate",
        ),
        ('"period": null', '"period": 2', r"controllers.pd.period = 2: must be a text"),
        ('"lower": 0.0', '"lower": {}', r"parameters\[0\].lower = \{\}: must be a number"),
        ('"delay": null,', "", "controllers.pd.delay is missing"),
        ('"of": ["u_torque"]', '"of": "u"', r"peak.of = 'u': must be a list"),
        (
            '"args": [["x", 2], ["u", 1], ["p',
            '"args": [["x"], ["p',
            r"functions.rhs.args\[0\] = \['x'\]: must be \[name, length\]",
        ),
        ('"schema": 1,', '"schema": 1', "is not JSON"),
    ],
)
def test_damaged_manifest(edited: Edit, old: str, new: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        read_manifest(edited(FILE, old, new))


def test_manifest_that_is_not_an_object(tmp_path: Path) -> None:
    (tmp_path / FILE).write_text(json.dumps([1, 2]))
    with pytest.raises(InputError, match="schema = None"):
        read_manifest(tmp_path)
    (tmp_path / FILE).write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match="is not UTF-8"):
        read_manifest(tmp_path)


@pytest.mark.parametrize(("file", "backend"), [("pendulum.c", "c"), ("pendulum.h", "c"), ("pendulum.py", "python")])
def test_missing_generated_file(edited: Edit, file: str, backend: str) -> None:
    copy = edited(FILE, "pendulum", "pendulum")
    (copy / file).unlink()
    with pytest.raises(InputError, match=re.escape(file)):
        runtime.load(copy, backend=backend).functions["initial"](np.zeros(10), np.zeros(4))  # type: ignore[arg-type]


def test_jacobians_are_compiled_on_first_use(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MEHVAR_CACHE", str(tmp_path))
    model = runtime.load(folder, backend="c")
    model.rhs([0.0, 0.0], [0.0], model.parameters())
    assert not list(tmp_path.rglob("pendulum_jac*.so"))
    model.jac_x([0.0, 0.0], [0.0], model.parameters())
    assert len(list(tmp_path.rglob("pendulum_jac*.so"))) == 1


def test_import_is_light() -> None:
    code = "import sys, runtime; print([m for m in ('scipy', 'xarray', 'pandas', 'sympy') if m in sys.modules])"
    root = Path(mehvar.__file__).parent.parent
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=root, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"states": [', '"states": [], "stats": [', "stats is not known"),
        ('["x", 2], ["u", 1], ["p', '["u", 1], ["x", 2], ["p', "functions.rhs = 'u x p -> dx': must be 'x u p -> dx'"),
        ('"rhs": {', '"slope": {', "functions: 'rhs' is missing"),
        ('"duration": 2.0', '"duration": NaN', "NaN is not a JSON number"),
        ('"duration": 2.0', '"duration": 1' + "0" * 400, "duration = 10000.*must be a number"),
        ('"duration": 2.0', '"duration": ' + "1" * 5000, "is not JSON"),
        ('"schema": 1', '"x": ' + "[" * 100_000, "nested too deeply"),
    ],
)
def test_a_manifest_that_does_not_fit_together(edited: Edit, old: str, new: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        read_manifest(edited(FILE, old, new))


def changed(folder: Path, **fields: Any) -> Path:
    data = json.loads((folder / FILE).read_text())
    write_manifest(folder, {**data, **fields})
    return folder


@pytest.mark.parametrize("backend", ["c", "python"])
def test_code_of_another_order_size_or_hash_is_refused(edited: Edit, backend: BackendName) -> None:
    copy = edited(FILE, "pendulum", "pendulum")
    data = json.loads((copy / FILE).read_text())
    for name in ("states", "outputs", "parameters"):
        changed(copy, **{name: data[name][::-1]})
        with pytest.raises(InputError, match=r"pendulum\.(h|py): .* is .*, and manifest.json says .*"):
            runtime.load(copy, backend=backend).functions["rhs"]([0.0, 0.0], [0.0], np.ones(10))
        changed(copy, **{name: data[name]})
    changed(copy, hash="1" * 64)
    with pytest.raises(InputError, match="says 1111"):
        runtime.load(copy, backend=backend).functions["rhs"]([0.0, 0.0], [0.0], np.ones(10))


def test_whatever_is_edited_in_a_manifest_by_hand_it_is_refused(edited: Edit) -> None:
    """Whatever number, word or order is changed, a space added or a key repeated: the cure is to generate again."""
    copy = edited(FILE, "pendulum", "pendulum")
    text = (copy / FILE).read_text()
    spans = [m.span() for m in re.finditer(r'"[^"]*"|-?[\d.]+(e-?\d+)?|true|false|null', text)]
    assert len(spans) > 900
    for start, end in spans:
        word = text[start:end]
        other = {"true": "false", "false": "true", "null": "0"}.get(word) or (
            f'"{word[1:-1]}_"' if word[0] == '"' else f"1{word}" if word[0] != "-" else word[1:]
        )
        (copy / FILE).write_text(text[:start] + other + text[end:])
        with pytest.raises(InputError):
            read_manifest(copy)
    for edit in (
        lambda t: t.replace('"schema": 1,', '"schema": 1, "title": "t",'),
        lambda t: t.replace(",\n", ", \n"),
        lambda t: json.dumps(json.loads(t)),
        lambda t: json.dumps({**json.loads(t), "digest": ""}, indent=1),
        lambda t: t.replace('["x", 2], ["u", 1]', '["u", 1], ["x", 2]'),
    ):
        (copy / FILE).write_text(edit(text))
        with pytest.raises(InputError, match=r"generat|is defined twice"):
            read_manifest(copy)
    (copy / FILE).write_text(text)
    read_manifest(copy)
