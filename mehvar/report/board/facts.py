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


def fact_rows(results: dict[str, Any]) -> list[tuple[str, str, str]]:
    """Return table rows of facts: description, value, evidence."""
    image, same = results["image"], results["equivalence"]
    rows = [
        ("board against host, in float", f"{results['max_ulp']} ulp", "all inputs and the law's memory, bit for bit"),
        ("inputs", f"{same['inputs']['max_ulp']} ulp of {same['inputs']['compared']}", "exact"),
        ("memory of the law", f"{same['memory']['max_ulp']} ulp of {same['memory']['compared']}", "exact"),
        ("states of the plant", f"{same['states']['max_ulp']} ulp of {same['states']['compared']}", "exact"),
        (
            "float against double",
            f"{results['float_against_double']['max_input']:.3g}",
            "largest of an input",
        ),
    ]
    undelayed = results["board_against_simulation_without_delay"]
    if undelayed:
        rows += [
            ("states, board against simulation without the delay", f"{undelayed['max_state']:.3g} at most", "measured"),
            ("the same, shifted by one sample", f"{undelayed['max_state_shifted']:.3g} at most", "measured"),
        ]
    if results["instructions_per_step"] is not None:
        least, most = results["instructions_least"], results["instructions_per_step"]
        rows += [("instructions of a step", f"{least} to {most}", "exact, counted by the emulator")]
    if results["cycles_per_step"]:
        text = f"{results['cycles_per_step']}, {results['microseconds_per_step']} µs"
        rows += [("cycles of a step", text, "estimate: Cortex-M4F timings, no wait states")]
    if "flash" in image:
        used, bound = results["stack_used"], results["stack_bound"]
        rows += [
            ("flash", f"{image['flash']} bytes", "exact"),
            ("static RAM", f"{image['ram']} bytes", "exact, without the stack"),
            ("stack, used", f"{used} bytes" if used else "not asked", "measured largest use, self-test included"),
            ("stack, at most", f"{bound['bytes']} bytes" if bound else "not known", _chain(bound)),
            ("stack, reserved", f"{image['stack']} bytes", "exact"),
            ("routines in double precision", ", ".join(image["double_routines"]) or "none", "exact, by symbols"),
        ]
    if results["selftest"]:
        test = results["selftest"]
        rows += [("self-test", f"0x{test['crc32']} after {test['samples']} samples", "exact, plant on the target too")]
    if (ticks := results["ticks"]) and ticks["most"]:  # an emulated clock stands still
        rows += [
            ("ticks of a step", f"{ticks['least']} to {ticks['most']} at {ticks['per_second']} /s", ticks["meaning"])
        ]
    return [*rows, ("exchanges", f"{results['exchanges_per_second']} /s", "measured on this machine")]


def _chain(bound: dict[str, Any] | None) -> str:
    if bound is None:
        return "unknown from the image"
    calls = " → ".join(f"{link['function']} {link['bytes']}" for link in bound["chain"])
    return f"bound from instructions and calls, one fault included: {calls}"
