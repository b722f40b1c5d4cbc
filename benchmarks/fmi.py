# SPDX-License-Identifier: Apache-2.0
"""Functional mock-up units in importers: FMPy, its CMake project, fmusim and CasADi.

Run: python -m benchmarks.fmi, in the environment of `make peers`. fmusim is looked for on $PATH; without it its column
is empty.
"""

from __future__ import annotations

import contextlib
import csv
import io
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from importlib.metadata import version
from itertools import product
from pathlib import Path

import casadi as ca
import numpy as np
import xarray
from numpy.typing import NDArray

import mehvar
from benchmarks.machine import command_line, machine, table, write

CASES = (("triangle", "path", 10.0, 0.125), ("slosh", "lyapunov-v1", 20.0, 0.25), ("satellite", "pd", 60.0, 0.5))
"""System, law, end and communication step, s. The step is exact in binary: sums of steps equal mehvar's instants."""
TOLERANCE = 1e-10
"""Tolerance of CVODE in model exchange, for differences below 1e-6."""
EXAMPLES = Path(__file__).parents[1] / "docs" / "examples" / "models"
COLUMNS = (
    "system", "FMI", "kind", "FMPy: messages", "FMPy: run", "CMake: run", "fmusim: run", "DaeBuilder: rates",
    "DaeBuilder: Jacobian",
)  # fmt: skip


def main() -> None:
    """Measure, and write the page."""
    rows: list[list[str]] = []
    with tempfile.TemporaryDirectory() as folder:
        others = (_own(Path(folder)), _example("cubli", "stand_up", 4.0, 0.015625, Path(folder)))
        for name, model, law, end, step in [*((case[0], *case) for case in CASES), *others]:
            for fmi, kind in product(("2.0", "3.0"), ("cs", "me")):
                rows.append(_row(name, model, law, end, step, fmi, kind, Path(folder)))
                _page(rows)  # what a run that is stopped has measured stays


def _page(rows: list[list[str]]) -> None:
    fmusim = shutil.which("fmusim")
    about = subprocess.run([fmusim, "--version"], capture_output=True, text=True).stdout.strip() if fmusim else "none"
    lines = [
        "# Functional mock-up units",
        "",
        "Written by `python -m benchmarks.fmi`. Closed loops, exported, validated and run by each importer, beside",
        "`mehvar.simulate`: the largest difference of a state over its largest value, where above 1; 0 is bit for bit.",
        "Co-simulation (`cs`) steps with our integrator; in model exchange (`me`) the importer integrates with CVODE,",
        f"tolerance {TOLERANCE:g}. *CMake*: FMPy built the binary from the unit's sources, with its CMake project.",
        "*fmusim* writes 16 digits. *DaeBuilder*: CasADi imported the plant; its rates at a point, and their Jacobian",
        "by the states, are compared with ours. `own` is what `mehvar new` writes, `cubli` has events. OMSimulator was",
        "not tried: its package downloads a program from a place that was out of reach.",
        "",
        "## Machine",
        "",
        *machine(),
        f"- importers: FMPy {version('fmpy')}, {about}, CasADi {version('casadi')}",
        "",
        "## Agreement",
        "",
        *table(COLUMNS, rows),
    ]
    write("fmi.md", lines)


def _own(folder: Path) -> tuple[str, str, str, float, float]:
    """Return the case of a system that `mehvar new` writes."""
    for words, place in ((["new", "own"], folder), (["generate", "own"], folder / "own")):
        subprocess.run([sys.executable, "-m", "mehvar", *words], cwd=place, check=True, capture_output=True)
    path = str(folder / "own" / "generated" / "own")
    law = next(iter(mehvar.load(path).manifest.controllers))
    return "own", path, law, 4.0, 0.125


def _example(name: str, law: str, end: float, step: float, folder: Path) -> tuple[str, str, str, float, float]:
    """Return the case of an example of the documentation."""
    shutil.copytree(EXAMPLES / name, folder / name / "models" / name)
    (folder / name / "generated").mkdir()
    subprocess.run([sys.executable, "-m", "mehvar", "generate"], cwd=folder / name, check=True, capture_output=True)
    return name, str(folder / name / "generated" / name), law, end, step


def _row(name: str, model: str, law: str, end: float, step: float, fmi: str, kind: str, folder: Path) -> list[str]:
    from fmpy import extract, read_model_description
    from fmpy.validation import validate_fmu

    path = folder / f"{name}{fmi[0]}{kind}.fmu"
    mehvar.export_fmu(model, path, controller=law, fmi=fmi, kind=kind)
    run = mehvar.simulate(model, law, t_end=end, dt_out=step)
    variables = {variable.name for variable in read_model_description(str(path)).modelVariables}
    names = [state for state in mehvar.load(model).state_names if state in variables]
    unpacked = Path(extract(str(path), str(path.with_suffix(""))))
    cells = [name, fmi, kind, str(len(validate_fmu(str(path)))), _by_fmpy(path, kind, run, names, step)]
    cells += [_by_cmake(unpacked, kind, run, names, step), _by_fmusim(path, kind, run, names, step)]
    cells += _by_casadi(model, fmi, path.with_name(f"{path.stem}_plant.fmu")) if kind == "me" else ("", "")
    print(cells, flush=True)
    return cells


def _by_fmpy(path: Path, kind: str, run: xarray.Dataset, names: list[str], step: float) -> str:
    import fmpy

    options = {"relative_tolerance": TOLERANCE} if kind == "me" else {}  # co-simulation has ours
    result = fmpy.simulate_fmu(
        str(path), stop_time=float(run["t"][-1]), output_interval=step, output=names, **options
    )  # fmt: skip
    return _difference({name: np.asarray(result[name]) for name in ("time", *names)}, run, names)


def _by_cmake(unpacked: Path, kind: str, run: xarray.Dataset, names: list[str], step: float) -> str:
    from fmpy.build import build_platform_binary

    shutil.rmtree(unpacked / "binaries")
    with tempfile.TemporaryDirectory() as build, contextlib.chdir(build):
        calls = subprocess.check_call
        subprocess.check_call = lambda command: calls(command, stdout=subprocess.DEVNULL)  # type: ignore[assignment]
        try:
            build_platform_binary(unpacked, build)
        finally:
            subprocess.check_call = calls
    return _by_fmpy(unpacked, kind, run, names, step)


def _by_fmusim(path: Path, kind: str, run: xarray.Dataset, names: list[str], step: float) -> str:
    if shutil.which("fmusim") is None:
        return ""
    out = path.with_suffix(".csv")
    options = ["--interface-type", kind, "--output-interval", repr(step), "--stop-time", repr(float(run["t"][-1]))]
    options += ["--solver", "cvode", "--output-file", str(out)]
    options += ["--tolerance", repr(TOLERANCE)] if kind == "me" else []
    options += [word for name in names for word in ("--output-variable", name)]
    done = subprocess.run(["fmusim", *options, str(path)], capture_output=True, text=True)
    if done.returncode:
        return f"exit {done.returncode}: {(done.stdout + done.stderr).strip().splitlines()[-1]}"
    head, *rows = csv.reader(io.StringIO(out.read_text()))
    columns = dict(zip(head, np.array(rows, dtype=float).T, strict=True))
    return _difference(columns, run, names)


def _by_casadi(model: str, fmi: str, path: Path) -> tuple[str, str]:
    from fmpy import extract

    mehvar.export_fmu(model, path, fmi=fmi, kind="me")
    builder, ours = ca.DaeBuilder("unit", str(extract(str(path)))), mehvar.load(model)
    generator = np.random.default_rng(1)
    x, u = generator.uniform(0.1, 0.9, len(ours.state_names)), generator.uniform(0.1, 0.9, len(ours.input_names))
    commanded = dict(zip(ours.input_names, u, strict=True))
    rhs, inputs = builder.create("rhs", ["x", "u"], ["ode"]), [commanded.get(name, 0.0) for name in builder.u()]
    rates, jacobian = rhs(x, inputs), rhs.jacobian()(x, inputs, 0)[0]
    p = ours.parameters()
    return (
        _largest(rates.full().ravel(), ours.rhs(x, u, p)),
        _largest(jacobian.full().ravel(), np.ravel(ours.functions["jac_x"](x, u, p))),
    )


def _difference(result: Mapping[str, NDArray[np.float64]], run: xarray.Dataset, names: list[str]) -> str:
    """Compare at the instants of mehvar's run; of the two rows at an event, use the first."""
    rows = [int(np.flatnonzero(np.isclose(result["time"], t, rtol=0, atol=1e-9))[-1]) for t in run["t"].values]
    return max((_largest(result[name][rows], run[name].values) for name in names), key=float)


def _largest(actual: NDArray[np.float64], expected: NDArray[np.float64]) -> str:
    return f"{np.max(np.abs(actual - expected)) / max(1.0, float(np.abs(expected).max())):.1e}"


if __name__ == "__main__":
    command_line(__doc__).parse_args()
    main()
