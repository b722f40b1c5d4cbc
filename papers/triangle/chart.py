# SPDX-License-Identifier: Apache-2.0
"""The chart of the triangle's laws: the shape relative to its target, equations (25)-(28).

Points of the disc are complex numbers: zeta = rho exp(i phi), and w = rho~ exp(i phi~) points from the shape to the
target zeta_f, turned by -phi_f.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from mehvar import Model
    from mehvar.runtime import Run


def target_shape(model: Model, run: Run) -> complex:
    """Return zeta_f of a run, by the model's own reference."""
    reference = model.functions["reference"](0.0, run.parameters.p, run.parameters.s)
    return complex(reference[0] * np.exp(1j * reference[1]))


def law_direction(model: Model, run: Run, w: ArrayLike, theta: ArrayLike, target: complex) -> NDArray[np.complex128]:
    """Return w'/w = rho~'/rho~ + i phi~' of a law's closed loop.

    Parameters
    ----------
    run : Run
        Gives the law, its parameters and mu.
    w : array_like of complex
        Where the shape is.
    theta : array_like
        Shifted attitude in rad.
    target : complex
        zeta_f, which need not be the run's.

    Returns
    -------
    array
        In 1/s, with the shape of `w` and `theta` broadcast.
    """
    points, a, phi = np.asarray(w, dtype=complex), abs(target), np.angle(target)
    zeta, mu = (a - points) * np.exp(1j * phi), run.x[-1, 2]
    attitude = np.asarray(theta) - a * points.imag
    q = np.stack(np.broadcast_arrays(zeta.real, zeta.imag, mu, attitude), axis=-1)
    loop = model.functions[f"{run.controller.name}_loop"]
    rate = loop(q, [a, phi, mu, 0.0], run.parameters.p, run.parameters.c)
    w_rate = -(rate[..., 0] + 1j * rate[..., 1]) * np.exp(-1j * phi)
    direction: NDArray[np.complex128] = w_rate / points
    return direction
