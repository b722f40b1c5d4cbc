# SPDX-License-Identifier: Apache-2.0
"""Numbers of a run on a board, for JSON and for the report."""

from __future__ import annotations

import hashlib
from typing import Any

import numpy as np

from mehvar.base.versions import installed
from mehvar.runtime.board.run import BoardRun, Difference
from mehvar.runtime.board.targets import TARGETS
from mehvar.runtime.run.simulate import Run

_PACKAGES = ("mehvar", "numpy", "unicorn", "ziglang", "python")


def facts(outcome: BoardRun) -> dict[str, Any]:
    """Return the numbers of a run; `max_ulp` and `instructions_per_step` come first."""
    request, image, profile = outcome.request, outcome.image, outcome.profile
    board, test = image.board, outcome.selftest
    return {
        "max_ulp": outcome.max_ulp,
        "instructions_per_step": profile.most if profile else None,
        "instructions_least": profile.least if profile else None,
        "cycles_per_step": profile.cycles or None if profile else None,
        "microseconds_per_step": _microseconds(outcome),
        "model": image.program.layout.model,
        "controller": image.program.layout.law,
        "scenario": image.program.scenario.name,
        "changed": {**(request.parameters or {}), **(request.options or {})},
        "target": request.target,
        "board": board.name if board else "posix",
        "compiler": image.toolchain.version,
        "samples": len(outcome.board.u_cmd),
        "period": image.program.period if outcome.board.hold is None else outcome.board.hold,
        "delay": int(outcome.board.options.get("delay", 0)),
        "status": outcome.board.status.text,
        "equivalence": {
            "inputs": _difference(outcome.u),
            "memory": _difference(outcome.z),
            "states": _difference(outcome.x),
        },
        "float_against_double": _differences(outcome.single, outcome.double),
        "board_against_simulation_without_delay": _differences(outcome.board, outcome.undelayed, outcome.board.hold),
        "exchanges_per_second": round(outcome.rate, 1),
        "ticks": _ticks(outcome),
        "image": _image(outcome),
        "stack_used": outcome.stats.get("stack_used") or None,
        "stack_bound": _bound(outcome),
        "coverage": [
            {"function": c.function, "lines": c.lines, "run": c.run, "missed": list(c.missed)} for c in outcome.covered
        ],
        "selftest": {"samples": test.samples, "crc32": f"{test.crc:08x}"} if test else None,
        "link": {
            "host": outcome.counters.as_dict() if outcome.counters else None,
            "board": dict(outcome.stats) or None,
            "restored": outcome.restored,
        },
        "tunings": [
            {"sample": t.sample, "values": dict(t.values), "refusal": t.refusal or None} for t in outcome.tunings
        ],
        "hash": image.program.layout.hash.hex(),
        "model_hash": image.program.model.manifest.hash,
        "versions": dict.fromkeys(_PACKAGES) | installed(*_PACKAGES),
    }


def _microseconds(outcome: BoardRun) -> float | None:
    board, profile = outcome.image.board, outcome.profile
    return round(1e6 * profile.cycles / board.hertz, 2) if board and profile and profile.cycles else None


def _difference(difference: Difference) -> dict[str, Any]:
    return {
        "compared": difference.compared,
        "max_ulp": difference.ulp,
        "max": difference.size,
        "first_sample": difference.first,
    }


def _differences(one: Run, other: Run | None, later: float | None = None) -> dict[str, Any] | None:
    """Return the largest and root mean square differences of inputs and states; `later` shifts by one sample."""
    if other is None:
        return None
    rows = min(len(one.u), len(other.u))
    du, dx = one.u[:rows] - other.u[:rows], one.x[:rows] - other.x[:rows]
    sizes = {"max_input": _largest(du), "max_state": _largest(dx), "rms_input": _rms(du), "rms_state": _rms(dx)}
    if later is not None and rows > 1:
        shifted = one.x[1:rows] - other.x[: rows - 1]
        sizes |= {"max_state_shifted": _largest(shifted), "rms_state_shifted": _rms(shifted)}
    return sizes


def _largest(values: np.ndarray[Any, np.dtype[np.float64]]) -> float:
    return float(np.abs(values).max(initial=0.0))


def _rms(values: np.ndarray[Any, np.dtype[np.float64]]) -> list[float]:
    return [float(v) for v in np.sqrt(np.square(values).mean(axis=0))]


def _ticks(outcome: BoardRun) -> dict[str, Any] | None:
    """Return the board's measurement of a step in ticks; None under an emulator."""
    if not outcome.ticks or outcome.hello is None:
        return None
    emulated = outcome.request.target in TARGETS and outcome.request.target != "sil"
    return {
        "least": min(outcome.ticks), "most": max(outcome.ticks), "per_second": outcome.hello.ticks_per_second,
        "meaning": "not a measurement: emulated clock" if emulated else "measured by the board",
    }  # fmt: skip


def _image(outcome: BoardRun) -> dict[str, Any]:
    content = outcome.image.path.read_bytes()
    numbers: dict[str, Any] = {"path": str(outcome.image.path), "sha256": hashlib.sha256(content).hexdigest()}
    if outcome.elf is not None:
        elf = outcome.elf
        numbers |= {"flash": elf.flash, "ram": elf.ram, "stack": elf.stack, "double_routines": elf.doubles()}
    return numbers


def _bound(outcome: BoardRun) -> dict[str, Any] | None:
    """Return the upper bound of the stack with the chain of calls that reaches it."""
    if outcome.bound is None:
        return None
    chain = [{"function": name, "bytes": size} for name, size in outcome.bound.chain]
    return {"bytes": outcome.bound.bytes, "chain": chain}
