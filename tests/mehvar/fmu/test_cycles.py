# SPDX-License-Identifier: Apache-2.0
"""FMUs under sanitizers, and as CasADi imports them."""

from __future__ import annotations

import subprocess
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import casadi as ca
import numpy as np

import mehvar
from tests.tools import needs

SANITIZERS = ("-fsanitize=address,undefined", "-fno-sanitize-recover=all")


def unpacked(folder: Path, **options: str) -> str:
    """Export, unpack, and return the token."""
    mehvar.export_fmu("triangle", folder / "unit.fmu", **options)
    with zipfile.ZipFile(folder / "unit.fmu") as archive:
        archive.extractall(folder)
        return str(ElementTree.fromstring(archive.read("modelDescription.xml")).get("guid"))


@needs("gcc")
def test_ten_thousand_instances_leave_nothing_behind(tmp_path):
    token = unpacked(tmp_path, controller="path")
    files = [str(Path(__file__).with_name("cycles.c")), "sources/unit.c", "sources/jacobians.c"]
    command = ["gcc", "-std=gnu11", "-g", "-O1", *SANITIZERS, "-Isources", *files, "-lm", "-o", "cycles"]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    done = subprocess.run([tmp_path / "cycles", token], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (0, "10000 cycles\n"), done.stderr


def test_casadi_imports_the_plant(tmp_path):
    """Right-hand sides by DaeBuilder are ours, bit for bit."""
    unpacked(tmp_path, kind="me")
    builder, model = ca.DaeBuilder("unit", str(tmp_path)), mehvar.load("triangle")
    rhs = builder.create("rhs", ["x", "u"], ["ode"])
    x = model.state(rho=0.3, phi=0.1, mu=0.2, theta=0.5)
    u = dict(zip(model.input_names, (0.1, 0.2, 0.05), strict=True))
    value = rhs(x, [u.get(name, 0.0) for name in builder.u()]).full().ravel()
    assert builder.x() == list(model.state_names)
    np.testing.assert_array_equal(value, model.rhs(x, list(u.values()), model.parameters()))
