# SPDX-License-Identifier: Apache-2.0
"""FMUs under sanitizers, and as CasADi imports them."""

from __future__ import annotations

import subprocess
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import casadi as ca
import numpy as np
import pytest

import mehvar
from tests.tools import needs

SANITIZERS = ("-fsanitize=address,undefined", "-fno-sanitize-recover=all")


def unpacked(folder: Path, model: str = "triangle", **options: str) -> str:
    """Export, unpack, and return the token."""
    mehvar.export_fmu(model, folder / "unit.fmu", **options)
    with zipfile.ZipFile(folder / "unit.fmu") as archive:
        archive.extractall(folder)
        about = ElementTree.fromstring(archive.read("modelDescription.xml"))
        return str(about.get("guid") or about.get("instantiationToken"))


def sanitized(folder: Path, program: str, token: str, *flags: str) -> subprocess.CompletedProcess[str]:
    """Compile a program of this folder with the unit's sources, and run it."""
    files = [str(Path(__file__).with_name(program)), "sources/unit.c", "sources/tangents.c"]
    command = ["gcc", "-std=gnu11", "-g", "-O0", *SANITIZERS, *flags, "-Isources", *files, "-lm", "-o", "program"]
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
    return subprocess.run([folder / "program", token], capture_output=True, text=True, check=False)


@needs("gcc")
@pytest.mark.soak
def test_ten_thousand_instances_leave_nothing_behind(tmp_path):
    done = sanitized(tmp_path, "cycles.c", unpacked(tmp_path, controller="path"))
    assert (done.returncode, done.stdout) == (0, "10000 cycles\n"), done.stderr


@needs("gcc")
@pytest.mark.parametrize(
    ("model", "law", "fmi"),
    [
        ("triangle", "path", "2.0"),
        ("satellite", "pd", "3.0"),  # with a law that has a memory
        pytest.param("triangle", "path", "3.0", marks=pytest.mark.soak),
        pytest.param("satellite", "pd", "2.0", marks=pytest.mark.soak),
    ],
)
@pytest.mark.share(2)
def test_wrong_calls_are_refused_and_change_nothing(model, law, fmi, tmp_path):
    """Unknown references, steps of no length or past the end, functions out of order, null pointers."""
    token = unpacked(tmp_path, model, controller=law, fmi=fmi)
    states = (tmp_path / "sources" / "fmu_model.h").read_text().split("FMU_NQ ", 1)[1].split()[0]
    done = sanitized(tmp_path, f"wrong{fmi[0]}.c", token, f"-DSTATES={states}")
    assert (done.returncode, done.stdout) == (0, "refused\n"), done.stderr


@pytest.mark.parametrize("fmi", ["2.0", "3.0"])
@pytest.mark.share(2)
def test_casadi_imports_the_plant(fmi, tmp_path):
    """Right-hand sides by DaeBuilder are ours, bit for bit."""
    unpacked(tmp_path, kind="me", fmi=fmi)
    builder, model = ca.DaeBuilder("unit", str(tmp_path)), mehvar.load("triangle")
    rhs = builder.create("rhs", ["x", "u"], ["ode"])
    x = model.state(rho=0.3, phi=0.1, mu=0.2, theta=0.5)
    u = dict(zip(model.input_names, (0.1, 0.2, 0.05), strict=True))
    value = rhs(x, [u.get(name, 0.0) for name in builder.u()]).full().ravel()
    assert builder.x() == list(model.state_names)
    np.testing.assert_array_equal(value, model.rhs(x, list(u.values()), model.parameters()))
