# SPDX-License-Identifier: Apache-2.0
"""How a name such as `lyapunov-v1` stands in code."""

from __future__ import annotations

import functools
import re

RESULT_NAMES = frozenset(
    """
    t run state variable event final minimum maximum events t_stop error steps violated status
    """.split()  # noqa: SIM905
)
"""What results and stores call their own variables and axes; no variable of a model has such a name."""

ARGUMENTS = frozenset(
    """
    model controller scenario parameters initial vary n seed sampling save out resume success until strict threads
    scheduler report progress law origin inputs interpolation period memory
    t_end dt_out hold delay run real method rtol atol step max_steps backend profile
    """.split()  # noqa: SIM905
)
"""What runs and batches call their own arguments and options; no parameter and no choice of a model has such a name,
for whoever gives it by name would set the other."""

WORK = "work"
"""What stands in place of a revision for what `models/` derives now; no model has this name."""

CLOCK = "clock"
"""What the last state of a plant of time is called: it is time, and has the rate one."""


@functools.lru_cache(maxsize=4096)  # of a few hundred names a model
def identifier(name: str) -> str:
    """Return the C and Python identifier of a name: what is neither letter, digit nor underscore becomes one."""
    return re.sub(r"\W", "_", name, flags=re.ASCII)
