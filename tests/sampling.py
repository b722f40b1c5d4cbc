# SPDX-License-Identifier: Apache-2.0
"""Random plausible arguments for generated functions, by the name of each element."""

import numpy as np

from mehvar.models.system import Group
from mehvar.physics.machine import draw

_PUSHES = ("F1", "F2", "F3", *(f"f{i}{axis}" for i in (1, 2, 3) for axis in "xy"))
RANGES = {
    "triangle": {
        "rho": (0.05, 0.6), "phi": (-3, 3), "mu": (0.1, 0.6), "theta": (-2, 2),
        "w1": (-1, 1), "w2": (-1, 1), "w3": (-0.1, 0.1),
        "zeta1": (-0.4, 0.4), "zeta2": (-0.4, 0.4),
        "rho_ref": (0.05, 0.6), "phi_ref": (-3, 3), "mu_ref": (0.1, 0.6), "theta_ref": (-1, 1),
        "theta_min": (0.05, 0.5), "rho_escape": (0.1, 0.8),
        "H": (-0.1, 0.1), "disturbance": (-0.01, 0.01), "R": (0.61, 0.7), "mu_rate_max": (0.01, 0.1),
        "l1": (0.3, 0.5), "l2": (0.3, 0.5), "l3": (0.3, 0.5), "t": (0, 10), "area_factor": (0.5, 1),
        **{f"l{k}_{end}": (0.3, 0.5) for k in (1, 2, 3) for end in "0f"},
        "psi": (-2, 2), "nu": (-3, 3), "nu_0": (-3, 3), "H_0": (-0.1, 0.1), "vx": (-1, 1), "vy": (-1, 1),
        "mean_motion": (0.5, 1), "eccentricity": (0.1, 0.6), "F_max": (0.5, 1.5), "thrust_max": (0.5, 1),
        "rate_max": (0.01, 0.1),
        **{f"{name}{end}": (-2, 2) for name in _PUSHES for end in ("", "_cmd")},
        **{f"u_l{k}{end}": (-0.5, 0.5) for k in (1, 2, 3) for end in ("", "_0")},
        **{f"l{k}_acc": (-2, 2) for k in (1, 2, 3)},
    },
    "slosh": {
        **{f"v{axis}": (-3, 3) for axis in "xyz"}, **{f"w{axis}": (-1, 1) for axis in "xyz"},
        **{f"att{k}": (-0.6, 0.6) for k in (1, 2, 3)},
        "q0": (0.7, 0.9), **{f"q{k}": (-0.3, 0.3) for k in (1, 2, 3)},
        **{f"M{axis}{end}": (-3, 3) for axis in "xyz" for end in ("", "_cmd")},
        **{f"delta{k}{end}": (-0.6, 0.6) for k in "12" for end in ("", "_cmd")},
        **{f"delta{k}_max": (0.1, 0.4) for k in "12"},
        "ay": (-0.5, 0.5), "az": (-0.5, 0.5), **{f"alpha{k}": (-0.5, 0.5) for k in (1, 2, 3)},
        "m": (4, 8), "m0": (2, 4), "I0": (1, 2), "J_x": (3, 4), "J_y": (3, 4), "J_z": (3, 4),
        "h0": (0.2, 0.6), "b": (-0.9, -0.5), "d": (1, 1.5), "F": (30, 40),
        **{f"m{k}": (1, 2) for k in range(1, 9)}, **{f"l{k}": (0.4, 0.8) for k in range(1, 9)},
        **{f"h{k}": (0.3, 0.9) for k in range(1, 9)}, **{f"I{k}": (0.2, 0.5) for k in range(1, 9)},
        **{f"eps{k}": (0.2, 0.8) for k in range(1, 9)},
        **{f"phi{k}{end}": (0.3, 1.2) for k in range(1, 9) for end in ("", "_0")},
        **{f"theta{k}{end}": (-1.5, 1.5) for k in range(1, 9) for end in ("", "_0")},
        **{f"{angle}{k}_dot{end}": (-1, 1) for angle in ("phi", "theta") for k in range(1, 9) for end in ("", "_0")},
        **{f"s{k}{axis}": (-0.8, 0.8) for k in range(1, 9) for axis in "xyz"},
        **{f"sigma{k}{axis}": (-1, 1) for k in range(1, 9) for axis in "xyz"},
        **{f"r{k}": (0.5, 1.5) for k in (1, 2, 3, 5, 7)}, **{f"r{k}": (2, 3) for k in (4, 6, 8)},
        **{f"r{k}": (0.1, 0.3) for k in (9, 10)}, **{f"w{k}": (0.1, 0.2) for k in range(1, 6)},
        **{f"v{axis}_0": (-3, 3) for axis in "xyz"}, **{f"w{axis}_0": (-1, 1) for axis in "xyz"},
        **{f"att{k}_0": (-0.6, 0.6) for k in (1, 2, 3)},
    },
    "satellite": {
        "roll": (-1, 1), "pitch": (-1, 1), "yaw": (-1, 1),
        "q0": (0.7, 0.9), **{f"q{k}": (-0.3, 0.3) for k in (1, 2, 3)},
        **{f"{name}{axis}": (-1, 1) for name in ("w", "h", "T") for axis in "xyz"},
        **{f"T{axis}_cmd": (-2, 2) for axis in "xyz"}, "latitude": (-3, 3),
        "Iw_x": (0.1, 0.3), "Iw_y": (0.1, 0.3), "Iw_z": (0.1, 0.3), "omega0": (0.3, 0.6),
        "orbit_radius": (1, 2), "inclination": (0.3, 1.2), "wheels": (0.55, 0.95), "umax": (0.5, 1.5),
        "hmax": (1, 2), "wheel_friction": (0.1, 0.3), "field_moment": (1, 2),
        **{f"{name}_{axis}": (-1, 1) for name in ("dipole", "arm") for axis in "xyz"},
        "air_density": (0.5, 1), "area": (0.4, 0.8), "solar_pressure": (0.3, 0.6), "reflectance": (0.3, 0.8),
        "sun_latitude": (-1, 1), "sun_elevation": (-0.8, 0.8),
        "noise": (0.01, 0.02), "noise_rate": (0.01, 0.02), "quantum": (0.01, 0.05), "torque_lost": (5, 9),
        **{f"e_{name}": (-2, 2) for name in ("roll", "pitch", "yaw", "wx", "wy", "wz")},
        "ref_roll": (-1, 1), "ref_pitch": (-1, 1), "ref_yaw": (-1, 1), "t": (0, 1000),
        **dict.fromkeys(
            ("design_delay", "follow_model", "matched", "adapt", "applied_regressor", "estimate_d"), (0.49, 0.51)
        ),
        "compensate_d": (0.5, 1.5),
        **{f"{b}_{axis}": (0.01, 0.1) for b in ("b0", "b1") for axis in ("roll", "pitch", "yaw")},
        **{f"{b}_{axis}_0": (-0.05, 0.1) for b in ("b0", "b1") for axis in ("roll", "pitch", "yaw")},
        "b_min": (0.02, 0.06), "b_min_ratio": (0.5, 1.5), "samples": (1, 3), "trace_max": (1, 5),
        "dead_zone": (0.3, 0.6), "dead_zone_sigma": (20, 40),
        **{f"{name}{k}": (-1, 1) for name in ("h", "T", "wheel_momentum_0_") for k in "1234"},
        **{f"T{k}_cmd": (-2, 2) for k in "1234"}, **{f"wheel_inertia_{k}": (0.1, 0.3) for k in "1234"},
        **{f"wheel_axes_{i}_{k}": (-1, 1) for i in "123" for k in "1234"},
    },
}  # fmt: skip


def sample(model: str, group: Group, n: int, rng: np.random.Generator) -> np.ndarray:
    """Return n random vectors of a group, shape (n, size); functions take one unused number for an empty group."""
    return draw(RANGES[model], group, n, rng)
