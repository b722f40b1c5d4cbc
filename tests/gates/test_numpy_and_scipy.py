# SPDX-License-Identifier: Apache-2.0
"""A generated folder needs NumPy and SciPy, and nothing else that is installed."""

from __future__ import annotations

import json
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PROGRAM = """
import json, sys
sys.path[:] = [place for place in sys.path if "site-packages" not in place]
sys.path[:0] = sys.argv[1:3]
import numpy as np
from scipy.integrate import solve_ivp
import mehvar
model = mehvar.load(sys.argv[3])
fun, jac, y0, _ = model.as_solve_ivp(u=[0.0, 0.001, 0.0])
run = solve_ivp(fun, (0.0, 10.0), y0, "Radau", jac=jac)
names = ["roll", "pitch", "yaw", "wx", "wy", "wz"]
x, u, residual = mehvar.trim(model, free=names, steady=names)
linear = model.linearize(x, u, model.parameters())
others = {name.split(".")[0] for name in sys.modules} & set(sys.argv[4:])
try:
    mehvar.simulate("satellite", controller="pd", t_end=1.0)
    refused = ""
except mehvar.MehvarError as error:
    refused = str(error)
print(json.dumps([run.status, float(abs(residual).max()), linear.A.shape, sorted(others), refused]))
"""
TOOLS = ("sympy", "casadi", "jinja2", "pydantic", "xarray", "zarr", "typer", "rich", "matplotlib")


@pytest.mark.soak
def test_a_generated_folder_runs_with_numpy_and_scipy_alone(tmp_path):
    """In an interpreter that finds these two among all that is installed; what needs more says what to install."""
    installed, alone = Path(sysconfig.get_path("purelib")), tmp_path / "alone"
    alone.mkdir()
    for name in ("numpy", "numpy.libs", "scipy", "scipy.libs"):
        if (installed / name).exists():
            (alone / name).symlink_to(installed / name)
    arguments = [alone, ROOT, ROOT / "generated" / "satellite", *TOOLS]
    done = subprocess.run([sys.executable, "-I", "-c", PROGRAM, *arguments], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    status, residual, shape, others, refused = json.loads(done.stdout.splitlines()[-1])
    assert (status, shape, others) == (0, [10, 10], [])
    assert residual < 1e-12
    assert "xarray" in refused
    assert "pip install" in refused
