# SPDX-License-Identifier: Apache-2.0
"""Conversion of names such as `lyapunov-v1` to identifiers, and reserved names."""

from __future__ import annotations

import functools
import re

RESULT_NAMES = frozenset(
    """
    t run state variable event final minimum maximum events t_stop error steps violated status
    """.split()  # noqa: SIM905
)
"""Names of variables and axes in results and stores, which a model must not use."""

ARGUMENTS = frozenset(
    """
    model controller scenario parameters initial vary n seed sampling save out resume success until strict threads
    require confidence scheduler report progress law origin inputs interpolation period memory points design
    t_end dt_out hold delay run real method rtol atol step max_steps backend profile
    """.split()  # noqa: SIM905
)
"""Names of arguments and options of runs and batches. Parameters and choices must differ from them, because all are
keywords.
"""

WORK = "work"
"""Word for the current sources in `models/`, in place of a git revision; no model may have this name."""

CLOCK = "clock"
"""Name of the time as a state: the last state of a time-varying plant, with rate one."""


_GREEK = frozenset(
    """
    alpha beta gamma delta epsilon zeta eta theta iota kappa lambda mu nu xi pi rho sigma tau upsilon phi chi psi omega
    Gamma Delta Theta Lambda Xi Pi Sigma Upsilon Phi Psi Omega
    """.split()  # noqa: SIM905
)


def typeset(name: str) -> str:
    r"""Return default LaTeX for a name: `theta_dot` gives \dot{\theta}, and `k_energy` an upright subscript."""
    base, *marks = name.split("_")
    word, digits = re.fullmatch(r"(.*?)([0-9]*)", base, re.DOTALL).groups()  # type: ignore[union-attr]
    below = [*([digits] if word and digits else ()), *(m for m in marks if m not in ("", "dot", "ddot"))]
    text = _typeset_word(word or base)
    for mark in ("ddot", "dot"):
        if mark in marks:
            text = rf"\{mark}{{{text}}}"
    return f"{text}_{{{','.join(map(_typeset_word, below))}}}" if below else text


def _typeset_word(word: str) -> str:
    if word in _GREEK:
        return rf"\{word}"
    return word if len(word) < 2 or word.isdigit() else rf"\mathrm{{{word}}}"


@functools.lru_cache(maxsize=4096)  # of a few hundred names a model
def identifier(name: str) -> str:
    """Return a name as an identifier of C and Python, with underscores for other characters."""
    return re.sub(r"\W", "_", name, flags=re.ASCII)
