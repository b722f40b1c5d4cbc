# SPDX-License-Identifier: Apache-2.0
"""Rotation matrices of many points, from their definitions."""

import numpy as np

from mehvar.physics.machine import Array


def of_angles(a: Array) -> Array:
    """Return R1(a1) R2(a2) R3(a3), shape (n, 3, 3): components to the frame turned by a3, a2, a1 about z, y, x."""
    return about(0, a[:, 0]) @ about(1, a[:, 1]) @ about(2, a[:, 2])


def of_quaternion(q: Array) -> Array:
    """Return the same for a quaternion, scalar first: (q0^2 - v.v) 1 + 2 v v' - 2 q0 [v x]."""
    w, v = q[:, 0], q[:, 1:]
    cross = np.zeros((len(q), 3, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        cross[:, i, j], cross[:, j, i] = -v[:, k], v[:, k]
    size = (w**2 - np.sum(v * v, axis=1))[:, None, None]
    return size * np.eye(3) + 2 * v[:, :, None] * v[:, None, :] - 2 * w[:, None, None] * cross


def quaternion(a: Array) -> Array:
    """Return the quaternion of the angles a3 about z, then a2 about y, then a1 about x."""
    (s1, s2, s3), (c1, c2, c3) = np.sin(a.T / 2), np.cos(a.T / 2)
    return np.column_stack(
        [
            c1 * c2 * c3 + s1 * s2 * s3,
            s1 * c2 * c3 - c1 * s2 * s3,
            c1 * s2 * c3 + s1 * c2 * s3,
            c1 * c2 * s3 - s1 * s2 * c3,
        ]
    )


def apply(matrix: Array, vector: Array) -> Array:
    """Multiply matrices by vectors, point by point."""
    return np.einsum("nij,nj->ni", matrix, vector)


def back(matrix: Array, vector: Array) -> Array:
    """Multiply the transposed matrices by vectors, point by point."""
    return np.einsum("nji,nj->ni", matrix, vector)


def about(axis: int, angle: Array) -> Array:
    """Return the matrices that take components to a frame turned about axis 0, 1 or 2."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    turn = np.zeros((len(angle), 3, 3))
    turn[:, axis, axis] = 1
    turn[:, i, i] = turn[:, j, j] = np.cos(angle)
    turn[:, i, j], turn[:, j, i] = np.sin(angle), -np.sin(angle)
    return turn
