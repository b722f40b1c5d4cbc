# SPDX-License-Identifier: Apache-2.0
"""Cost and requirements of importing."""

import os
import subprocess
import sys

import numpy as np
import pytest

import mehvar

HEAVY = ("sympy", "casadi", "pydantic", "jinja2", "xarray", "pandas", "matplotlib", "typer", "rich", "scipy")


def python(code: str) -> str:
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


@pytest.mark.parametrize("module", ["mehvar", "mehvar.runtime"])
def test_importing_stays_light(module):
    assert python(f"import sys, {module}; print([m for m in {HEAVY} if m in sys.modules])") == "[]"


@pytest.mark.parametrize(
    "command", ["list", "show triangle", "simulate triangle --controller path --t-end 1", "generate triangle --check"]
)
def test_commands_import_little(command):
    """They need no pydantic, although typer converts values by it, and no metadata of installed packages."""
    heavy = (
        {*HEAVY, "importlib.metadata"} - {"typer", "rich"} - ({"importlib.metadata"} if "--check" in command else set())
    )
    code = (
        f"import sys\nfrom mehvar.__main__ import main\nsys.argv = ['mehvar', *{command.split()}]\n"
        f"try: main()\nexcept SystemExit: pass\nprint([m for m in {sorted(heavy)} if m in sys.modules])"
    )
    assert python(code).splitlines()[-1] == "[]"


def test_a_batch_and_its_statistics_do_without_scipy(tmp_path):
    """Importing it takes longer than a small batch."""
    code = (
        "import sys\nsys.modules['scipy'] = None\n"
        "from mehvar.runtime.batch.fill import run_batch\n"
        "from mehvar.runtime.batch.plan import Campaign\n"
        "from mehvar.runtime.batch.evaluation.statistics import summarise\n"
        "store = run_batch('triangle', Campaign('path', 8, options={'t_end': 0.1}), 'runs.zarr')\n"
        "print(summarise(store).successes)"
    )
    assert python(f"import os\nos.chdir({str(tmp_path)!r})\n{code}") == "8"


@pytest.mark.parametrize("kind", ["package", "module"])
@pytest.mark.soak
def test_a_users_own_folders_or_files_of_our_rooms_names(kind, tmp_path):
    """Neither is taken for the other: from the command line, in a script beside it, and in a process that it spawns."""
    rooms = ("models", "runtime", "codegen", "generated")
    for name in rooms:
        theirs = tmp_path / f"{name}.py" if kind == "module" else tmp_path / name / "__init__.py"
        theirs.parent.mkdir(exist_ok=True)
        theirs.write_text("OWNER = 'the user'\n")
    names, owners = ", ".join(rooms), ", ".join(f"{name}.OWNER" for name in rooms)
    (tmp_path / "script.py").write_text(
        f"import multiprocessing\nimport {names}\nimport mehvar\n\n"
        "def answer(_):\n"
        f"    return {owners}, mehvar.simulate('triangle', 'path', t_end=0.1).attrs['status']\n\n"
        "if __name__ == '__main__':\n"
        "    mehvar.System, mehvar.to_casadi\n"
        "    with multiprocessing.get_context('spawn').Pool(1) as pool:\n"
        "        print([answer(0), *pool.map(answer, [0])])\n"
    )
    (tmp_path / "test_beside.py").write_text(
        f"import {names}, mehvar\n\ndef test_both():\n    assert {{{owners}}} == {{'the user'}} and mehvar.System\n"
    )
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONSAFEPATH"}
    for command in (
        ["-m", "mehvar", "simulate", "triangle", "--controller", "path", "--t-end", "1"],
        ["script.py"],
        ["-m", "pytest", "-q", "-p", "no:cacheprovider", "--import-mode=prepend", "test_beside.py"],
    ):
        done = subprocess.run([sys.executable, *command], cwd=tmp_path, env=environment, capture_output=True, text=True)
        assert done.returncode == 0, done.stdout + done.stderr
        if command == ["script.py"]:
            assert done.stdout.count("the user") == 2 * len(rooms)


@pytest.mark.parametrize("backend", ["c", "python"])
def test_generated_models_run_on_numpy_and_scipy_alone(backend):
    """With SymPy, CasADi and all other parts made impossible to import."""
    blocked = tuple(name for name in HEAVY if name != "scipy")
    code = (
        f"import sys\nfor name in {blocked}: sys.modules[name] = None\n"
        "from mehvar.runtime import load, simulate\n"
        f"m = load('triangle', {backend!r})\n"
        "m.jac_x(m.state(rho=0.3, mu=0.2), [0, 0, 0], m.parameters())\n"
        "print(simulate(m, 'path', t_end=1.0).status.name)"
    )
    assert python(code) == "DONE"


def test_every_public_name_is_there():
    for name in mehvar.__all__:
        assert getattr(mehvar, name).__doc__, name
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = mehvar.nothing


def test_the_contract_of_a_model():
    m = mehvar.load("triangle")
    assert m.state_names == ("rho", "phi", "mu", "theta")
    assert m.input_names == ("w1", "w2", "w3")
    x, u, p = m.state(rho=0.3, mu=0.2), np.array([0.1, 0.2, 0.0]), m.parameters(H=0.01)
    assert m.rhs(np.stack([x] * 5), u, p).shape == (5, 4)
    A, B, C, D = m.linearize(x, u, p)
    assert (A.shape, B.shape, C.shape, D.shape) == ((4, 4), (4, 3), (4, 4), (4, 3))
    np.testing.assert_allclose(A[3], [2 * 0.3 * 0.2, 0, -3 * 0.01 / 0.2**2, 0], atol=1e-15)
    rho, phi, mu = m.functions["shape"](*m.functions["lengths"](0.3, 0.4, 0.2))
    np.testing.assert_allclose([rho, phi, mu], [0.3, 0.4, 0.2], atol=1e-15)
    assert m.functions["length_rates"](x, u).shape == (3,)
    with pytest.raises(ValueError, match="no_such_parameter"):
        m.parameters(no_such_parameter=1.0)


def test_a_result_carries_units_and_its_manifest():
    ds = mehvar.simulate("triangle", controller="sliding", scenario="paper", t_end=1.0, disturbance=0.001)
    assert ds.t.attrs["units"] == "s"
    for name in ("rho", "theta", "l1", "u_l1", "u_w1"):
        assert ds[name].attrs["units"]
    assert ds.attrs["model_hash"] in ds.attrs["manifest"]
