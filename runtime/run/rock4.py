# SPDX-License-Identifier: Apache-2.0
"""The method `rock4` as a solver of SciPy's, for the Python backend."""

from __future__ import annotations

import numpy as np
from scipy.integrate import RK45

from ..compiling.library import NATIVE

_STAGES = 16


class Rock4(RK45):  # type: ignore[misc]  # SciPy has no annotations
    """Sixteen stages of order four with a long stable piece of the negative real axis.

    The coefficients of the native integrator, from `native/methods/rock4.inc`; dense output is the cubic Hermite
    polynomial of a step. Source: Abdulle, SIAM J. Sci. Comput. 23 (2002) 2041.
    """

    order, error_estimator_order, n_stages = 4, 3, _STAGES
    _text = (NATIVE / "methods" / "rock4.inc").read_text(encoding="utf-8")
    _rows = np.array(_text.rstrip(",\n").split(","), dtype=np.float64).reshape(_STAGES + 3, _STAGES)
    A, B, C = _rows[:_STAGES], _rows[_STAGES], _rows[_STAGES + 1]
    E = np.append(_rows[_STAGES + 2], 0.0)
    _start, _end, _all = np.eye(_STAGES + 1)[0], np.eye(_STAGES + 1)[-1], np.append(B, 0.0)
    P = np.stack([_start, 3 * _all - 2 * _start - _end, _start + _end - 2 * _all], axis=1)
