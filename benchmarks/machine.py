# SPDX-License-Identifier: Apache-2.0
"""Command line of a benchmark, its machine, and its tables."""

from __future__ import annotations

import argparse
import os
import platform
import subprocess
from collections.abc import Callable, Iterable, Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from statistics import median
from time import perf_counter

from mehvar.runtime.compiling.compiler import find_compiler

RESULTS = Path(__file__).parent / "results"


def command_line(about: str | None, parts: Iterable[str] = ()) -> argparse.ArgumentParser:
    """Return a parser for some of the `parts`, or for no arguments."""
    parser = argparse.ArgumentParser(description=about, formatter_class=argparse.RawDescriptionHelpFormatter)
    names = tuple(parts)

    def known(text: str) -> str:
        if text in names:
            return text
        raise argparse.ArgumentTypeError(f"{text!r} is none of {', '.join(names)}")

    if names:
        parser.add_argument("parts", nargs="*", type=known, metavar="|".join(names), help="default: all")
    return parser


def machine() -> list[str]:
    """Name processor, load, system, compiler and versions; never the host."""
    compiler = find_compiler()
    packages = ", ".join(f"{name} {version(name)}" for name in ("mehvar", "numpy", "scipy", "sympy", "casadi"))
    return [
        f"- processor: {_processor()}, {os.cpu_count()} logical cores seen; "
        f"other programs kept {os.getloadavg()[0]:.1f} busy when the benchmark began",
        f"- system: {platform.system()} {platform.machine()}, Python {platform.python_version()}",
        f"- C compiler: {compiler.version if compiler else 'none'}",
        f"- packages: {packages}",
    ]


def interleaved(jobs: Mapping[str, Callable[[], object]], repeats: int) -> dict[str, float]:
    """Return the median wall time of each job, s; the jobs take turns, so that drift affects all of them."""
    times: dict[str, list[float]] = {name: [] for name in jobs}
    for _ in range(repeats):
        for name, job in jobs.items():
            start = perf_counter()
            job()
            times[name].append(perf_counter() - start)
    return {name: median(values) for name, values in times.items()}


def table(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """Return a Markdown table."""
    lines = [columns, ["---"] * len(columns), *rows]
    return [f"| {' | '.join(line)} |" for line in lines]


def write(name: str, lines: Sequence[str]) -> None:
    """Print a result and write it to benchmarks/results."""
    text = "\n".join(lines) + "\n"
    print(text)
    (RESULTS / name).write_text(text, encoding="utf-8", newline="\n")


def _processor() -> str:
    listed = subprocess.run(["lscpu"], capture_output=True, text=True, check=False, env={**os.environ, "LC_ALL": "C"})
    for line in listed.stdout.splitlines():
        key, _, value = line.partition(":")
        if key.strip() == "Model name":
            return value.strip()
    return platform.processor() or "unknown"
