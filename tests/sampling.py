# SPDX-License-Identifier: Apache-2.0
"""Random plausible arguments for generated functions, by the name of each element."""

import numpy as np

from models.system import Group, Parameter

RANGES = {
    "triangle": {
        "rho": (0.05, 0.6), "phi": (-3, 3), "mu": (0.1, 0.6), "theta": (-2, 2),
        "w1": (-1, 1), "w2": (-1, 1), "w3": (-0.1, 0.1),
        "zeta1": (-0.4, 0.4), "zeta2": (-0.4, 0.4),
        "rho_ref": (0.05, 0.6), "phi_ref": (-3, 3), "mu_ref": (0.1, 0.6), "theta_ref": (-1, 1),
        "H": (-0.1, 0.1), "disturbance": (-0.01, 0.01), "R": (0.61, 0.7), "mu_rate_max": (0.01, 0.1),
        "l1": (0.3, 0.5), "l2": (0.3, 0.5), "l3": (0.3, 0.5), "t": (0, 10), "area_factor": (0.5, 1),
        **{f"l{k}_{end}": (0.3, 0.5) for k in (1, 2, 3) for end in "0f"},
    },
}  # fmt: skip


def sample(model: str, group: Group, n: int, rng: np.random.Generator) -> np.ndarray:
    """Return n random vectors of a group, shape (n, size)."""
    return np.stack([rng.uniform(*_range(model, q), size=n) for q in group], axis=-1)


def _range(model, quantity):
    if quantity.name in RANGES[model]:
        return RANGES[model][quantity.name]
    if isinstance(quantity, Parameter) and isinstance(quantity.default, float) and quantity.default:
        return tuple(sorted((0.8 * quantity.default, 1.25 * quantity.default)))
    return (0.1, 1.0)
