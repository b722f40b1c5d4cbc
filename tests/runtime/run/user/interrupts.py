# SPDX-License-Identifier: Apache-2.0
"""Signals at any time of runs and batches: each ends the call with the handler's exception.

python -m tests.runtime.run.user.interrupts COUNT [SEED [KIND ...]]

prints for each kind of run, or for those that are named, what became of the signals that came to it, and the
traceback of what was raised instead; exits 1 if one was swallowed, or raised something else than its handler does.
"""

from __future__ import annotations

import math
import random
import signal
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import mehvar
from mehvar import runtime
from mehvar.runtime.batch.fill import run_batch
from mehvar.runtime.batch.plan import Campaign
from tests.fuzz.inputs import PENDULUM

Run = Callable[[], object]


class PressedError(Exception):
    """The exception of a signal handler, such as one that limits the time of a run."""


def law(_t: float, x: Any) -> list[float]:
    """A law without a memory, which also calls NumPy."""
    return [float(-2.0 * np.sin(x.angle) - 0.5 * x.rate)]


def remembering(_t: float, x: Any, z: Any) -> tuple[list[float], Any]:
    """A law with a memory."""
    return [-2.0 * x.angle - 0.1 * z[0]], z + x.angle


def runs(model: runtime.Model) -> dict[str, Run]:
    """Return runs of each kind that call a user's function, and a run of a store."""
    short = {"period": 0.005, "dt_out": 0.005, "t_end": 1.0}
    return {
        "law": lambda: runtime.simulate(model, law, **short),
        "memory": lambda: runtime.simulate(model, remembering, memory=[0.0], **short),
        "inputs": lambda: runtime.simulate(model, None, inputs={"torque": math.sin}, **short),
        "progress": lambda: runtime.simulate(model, "pd", progress=lambda t, end: None, t_end=1.0, dt_out=0.001),
        "batch": lambda: mehvar.batch(model, law_of_many, 4, threads=1, **short),
        "store": lambda: _stored(model),
    }


def _stored(model: runtime.Model) -> None:
    """Write a batch of several blocks and open it."""
    with tempfile.TemporaryDirectory() as folder:
        campaign = Campaign("pd", 4, options={"t_end": 0.1, "dt_out": 0.01})
        run_batch(model, campaign, Path(folder) / "runs.zarr", chunk=2, threads=1)
        mehvar.open_result(Path(folder) / "runs.zarr")


def law_of_many(_t: float, x: Any) -> list[Any]:
    """A law of all runs at once."""
    return [-2.0 * np.sin(x.angle) - 0.5 * x.rate]


def outcome(run: Run, delay: float, error: type[BaseException]) -> str:
    """Return the effect of a signal after `delay` seconds: missed, raised, changed or swallowed."""
    came: list[bool] = []
    ended = False

    def handler(*_: object) -> None:
        if not ended:
            came.append(True)
            raise error

    before = signal.signal(signal.SIGALRM, handler)
    try:
        signal.setitimer(signal.ITIMER_REAL, delay)
        run()
        ended = True
    except BaseException as raised:
        if type(raised) is error:
            return "raised"
        traceback.print_exception(raised)
        return "changed"
    finally:
        ended = True
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
    return "swallowed" if came else "missed"


def campaign(run: Run, count: int, seed: int) -> Counter[str]:
    """Send signals until `count` of them have reached a run."""
    run()
    start = time.perf_counter()
    run()
    span, draw, counts = time.perf_counter() - start, random.Random(seed), Counter[str]()
    while counts.total() - counts["missed"] < count:
        error = draw.choice([KeyboardInterrupt, PressedError])
        counts[outcome(run, draw.uniform(1e-5, span), error)] += 1
    return counts


def main(count: str, seed: str = "1", *names: str) -> int:
    """Print the effects of the signals."""
    lost = 0
    kinds = runs(runtime.load(PENDULUM, "c"))
    names = names or tuple(kinds)
    for number, name in enumerate(names):
        counts = campaign(kinds[name], -(-int(count) // len(names)), int(seed) + number)
        print(name, dict(counts), flush=True)
        lost += counts["swallowed"] + counts["changed"]
    return int(lost > 0)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
