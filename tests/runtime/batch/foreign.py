# SPDX-License-Identifier: Apache-2.0
"""The kernel of a batch on another processor, under QEMU's user mode."""

from __future__ import annotations

import ctypes
import dataclasses
import subprocess
from pathlib import Path
from typing import Any

import numpy as np

from mehvar import runtime
from mehvar.runtime.batch.kernel import Kernel, compile_kernel
from mehvar.runtime.board.image.processors import process_toolchain
from mehvar.runtime.compiling.library import FLAGS
from mehvar.runtime.compiling.structures import structures
from mehvar.runtime.model.parameters import resolve

RUNS, LANES = 5, 2
"""NEON has two doubles in a register; five runs leave one lane idle."""
_POINTERS = ("p", "c", "s", "x0", "metric", "signal", "final", "minimum", "maximum", "metric_values", "t_stop", "error",
             "t_stiff", "number", "series", "steps", "violated", "status", "stop")  # fmt: skip


class ForeignLibrary:
    """Substitute for a kernel's library: each call runs the blocks in a process of the other processor."""

    def __init__(self, kernel: Kernel, processor: str, folder: Path) -> None:
        self._kernel = kernel
        self._toolchain = process_toolchain(processor, "gcc")
        self._program = folder / "foreign"
        own = Path(__file__).with_name("foreign.c")
        for name, text in {**kernel.loop.sources, own.name: own.read_text()}.items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_text(text)
        flags = [flag for flag in FLAGS if flag not in ("-fPIC", "-shared")]
        flags += ["-O2", "-fno-tree-slp-vectorize", "-Wno-psabi", f"-DMEHVAR_LANES={kernel.lanes}", "-I."]
        units = ["batch.c", own.name]
        subprocess.run(
            [*self._toolchain.command, *flags, *units, "-o", self._program.name, "-lm"], cwd=folder, check=True
        )

    def mv_work_size(self, _job: object) -> int:
        """Return 0; the other process has its own address."""
        return 0

    def mv_run_blocks(self, reference: Any, first: int, end: int, _place: int) -> None:
        """Run some blocks there and bring back the arrays."""
        job = reference._obj
        sizes = self._sizes(job)
        layout = {name: (getattr(type(job), name).offset, sizes[name]) for name in _POINTERS}
        layout["t"] = (type(job).schedule.offset + type(job.schedule).t.offset, 8 * job.schedule.ticks)
        address = {name: getattr(job, name) for name in _POINTERS} | {"t": job.schedule.t}
        message = bytes(job) + np.array([first, end, len(layout)], np.int64).tobytes()
        for name, place in layout.items():
            message += np.array(place, np.int64).tobytes() + ctypes.string_at(address[name], place[1])
        done = subprocess.run(
            [*self._toolchain.emulator, self._program], input=message, stdout=subprocess.PIPE, check=True
        )
        assert len(done.stdout) == sum(size for _, size in layout.values())
        at = 0
        for name, (_, size) in layout.items():
            ctypes.memmove(address[name], done.stdout[at : at + size], size)
            at += size

    def _sizes(self, job: Any) -> dict[str, int]:
        loop = self._kernel.loop
        manifest, law = loop.manifest, loop.controller
        signals = sum(len(metric.of) for metric in loop.metrics)
        widths = {
            "p": len(manifest.parameters), "c": len(law.parameters), "s": len(manifest.scenario_parameters),
            "x0": len(manifest.states), "final": len(manifest.states), "minimum": len(loop.variables),
            "maximum": len(loop.variables), "metric_values": len(loop.metrics), "t_stop": 1, "error": 1,
            "t_stiff": 1, "number": 1, "series": job.rows * len(loop.variables), "steps": 1,
        }  # fmt: skip
        sizes = {name: 8 * job.runs * width for name, width in widths.items()}
        types = structures("step/schedule.h", "batch/job.h")
        metric, signal = (ctypes.sizeof(types[name]) for name in ("mv_metric", "mv_signal"))
        sizes |= {"metric": metric * job.metrics, "signal": signal * signals}
        return sizes | {"violated": 4 * job.runs, "status": job.runs, "stop": ctypes.sizeof(ctypes.c_int32)}


def differing(model: runtime.Model, law: str, processor: str, folder: Path, samples: int) -> list[str]:
    """Return the results of a batch that are not bit-identical to this machine's, with two lanes on both."""
    manifest = model.manifest
    controller, scenario = manifest.controller(law), manifest.scenario(None)
    resolved = resolve(manifest, model.functions, controller, scenario, {}, "the table")
    kernel = compile_kernel(model, law, lanes=LANES)
    x0 = np.asarray(model.functions["initial"](resolved.p, resolved.s), np.float64)
    rows = {name: np.tile(getattr(resolved, name), (RUNS, 1)) for name in "pcs"}
    starts = x0 + 1e-3 * np.arange(RUNS)[:, None]
    call = {"first_run": 0, **rows, "x0": starts, "seed": 1, "dt": scenario.step, "t_end": samples * scenario.step}
    here = kernel.run(**call, save_every=scenario.step)
    there = dataclasses.replace(kernel, library=ForeignLibrary(kernel, processor, folder))
    away = there.run(**call, save_every=scenario.step)
    assert here is not None
    assert away is not None
    assert np.isfinite(here.final).all()
    fields = [field.name for field in dataclasses.fields(here)]
    return [name for name in fields if getattr(here, name).tobytes() != getattr(away, name).tobytes()]
