# SPDX-License-Identifier: Apache-2.0
"""Mechanics for all systems: rotations, products, time derivatives."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import sympy as sp
from sympy.polys.rings import PolyRing

from .arguments import expression, expressions, rates_of, symbols
from .quantities import wrong

QUARTER_TURN = sp.Matrix([[0, -1], [1, 0]])
"""Rotation of the plane by +90 degrees, the paper's J."""


def time_derivative(expr: sp.Expr, rates: Mapping[sp.Symbol, sp.Expr]) -> sp.Expr:
    """Differentiate an expression along a motion, by the chain rule.

    Parameters
    ----------
    expr : Expr
        The expression.
    rates : mapping of Symbol to Expr
        Time derivative of each symbol that depends on time; all others are constant.
    """
    subject, slopes = expression("expr", expr), _Slopes()
    return sp.Add(*(slopes(subject, symbol) * rate for symbol, rate in rates_of(rates).items()))


def gradient(expr: sp.Expr, symbols: Iterable[sp.Symbol]) -> tuple[sp.Expr, ...]:
    """Return the partial derivatives of an expression.

    Parameters
    ----------
    expr : Expr
        The expression.
    symbols : iterable of Symbol
        The variables; all other symbols are constant.
    """
    subject, slopes = expression("expr", expr), _Slopes()
    return tuple(slopes(subject, symbol) for symbol in symbols)


class _Slopes:
    """Partial derivatives as SymPy's, which collects the symbols of every subexpression anew for each symbol."""

    def __init__(self) -> None:
        self._symbols: dict[sp.Basic, set[sp.Basic]] = {}

    def __call__(self, expr: sp.Expr, symbol: sp.Symbol) -> sp.Expr:
        """Differentiate sums, products and powers here, and leave other functions to SymPy."""
        if expr not in self._symbols:
            self._symbols[expr] = expr.free_symbols
        if symbol not in self._symbols[expr]:
            return sp.S.Zero
        if type(expr) is sp.Add:
            return sp.Add(*(self(term, symbol) for term in expr.args))
        if type(expr) is sp.Mul:
            factors = expr.args
            slopes = [self(factor, symbol) for factor in factors]
            return sp.Add(
                *(sp.Mul(*factors[:k], s, *factors[k + 1 :]) for k, s in enumerate(slopes) if s is not sp.S.Zero)
            )
        if type(expr) is sp.Pow and expr.exp.is_Number:
            return expr * (self(expr.base, symbol) * expr.exp / expr.base)
        return expr.diff(symbol)


def expanded(expr: sp.Expr) -> sp.Expr:
    """Expand an expression as `sympy.expand`; polynomials in symbols and functions of symbols take half of the time."""
    variables, stack = dict[sp.Expr, None](), [expr]
    while stack:
        node = stack.pop()
        if isinstance(node, sp.Add | sp.Mul):
            stack += node.args
        elif isinstance(node, sp.Pow) and node.exp.is_Integer and node.exp > 0:
            stack.append(node.base)
        elif isinstance(node, sp.Symbol) or (isinstance(node, sp.Function) and all(a.is_Symbol for a in node.args)):
            variables[node] = None
        elif not node.is_Rational:
            return sp.expand(expr)
    return PolyRing(tuple(variables), sp.QQ).from_expr(expr).as_expr() if variables else expr


def matrix_rate(matrix: sp.Matrix, rates: Mapping[sp.Symbol, sp.Expr]) -> sp.Matrix:
    """Differentiate a matrix along a motion, entry by entry.

    Parameters
    ----------
    matrix : sympy.Matrix
        The matrix.
    rates : mapping of Symbol to Expr
        Time derivatives of the symbols.
    """
    return matrix.applyfunc(lambda entry: time_derivative(entry, rates))


def planar_cross(a: sp.Matrix, b: sp.Matrix) -> sp.Expr:
    """Return the out-of-plane component of a x b for plane vectors.

    Parameters
    ----------
    a, b : sympy.Matrix
        Two components each.
    """
    return a[0] * b[1] - a[1] * b[0]


def rotate(vector: tuple[sp.Expr, sp.Expr], cosine: sp.Expr, sine: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
    """Rotate a plane vector by an angle, given by its cosine and sine."""
    x, y = vector
    return x * cosine - y * sine, x * sine + y * cosine


def frame_turn(axis: int, angle: sp.Expr) -> sp.Matrix:
    """Return the matrix that transforms components into a rotated frame.

    Parameters
    ----------
    axis : int
        0, 1 or 2.
    angle : Expr
        Angle of the turn about it, rad.
    """
    i, j = (axis + 1) % 3, (axis + 2) % 3
    turn = sp.eye(3)
    turn[i, i] = turn[j, j] = sp.cos(angle)
    turn[i, j], turn[j, i] = sp.sin(angle), -sp.sin(angle)
    return turn


def direction(ascension: sp.Expr, declination: sp.Expr) -> sp.Matrix:
    """Return an inertial direction."""
    across = sp.cos(declination)
    return sp.Matrix([across * sp.cos(ascension), across * sp.sin(ascension), sp.sin(declination)])


def cross_matrix(vector: sp.Matrix) -> sp.Matrix:
    """Return the matrix of the cross product with `vector` on the left."""
    x, y, z = vector
    return sp.Matrix([[0, -z, y], [z, 0, -x], [-y, x, 0]])


def reduce_sines(expr: sp.Expr) -> sp.Expr:
    """Expand an expression and replace even powers of sines, which makes trigonometric polynomials unique."""

    def even(power: sp.Pow) -> sp.Expr:
        square = 1 - sp.cos(power.base.args[0]) ** 2
        return square ** (power.exp // 2) * power.base ** (power.exp % 2)

    def is_power_of_sine(term: sp.Basic) -> bool:
        return isinstance(term, sp.Pow) and isinstance(term.base, sp.sin) and bool(term.exp.is_Integer)

    return expanded(expanded(expr).replace(is_power_of_sine, even))


def angular_velocity(rotation: sp.Matrix, rates: Mapping[sp.Symbol, sp.Expr]) -> sp.Matrix:
    """Return the angular velocity Omega of a rotated frame in its own axes, from C' = -[Omega x] C.

    Parameters
    ----------
    rotation : sympy.Matrix
        Matrix C that takes components to the turned frame.
    rates : mapping of Symbol to Expr
        Time derivatives of its symbols.
    """
    spin = -matrix_rate(rotation, rates) * rotation.T
    return sp.Matrix([reduce_sines(spin[row, column]) for row, column in ((2, 1), (0, 2), (1, 0))])


def angle_rates(rotation: sp.Matrix, angles: Sequence[sp.Symbol], omega: Sequence[sp.Expr]) -> sp.Matrix:
    """Return the rates of three angles for a given angular velocity of the frame.

    Parameters
    ----------
    rotation : sympy.Matrix
        Matrix that takes components to the turned frame, a function of the angles.
    angles : sequence of Symbol
        Three angles, rad.
    omega : sequence of Expr
        Rate of the turned frame in its own axes, rad/s.
    """
    unknown = sp.symbols("rate_0:3", real=True)
    spin = angular_velocity(rotation, dict(zip(angles, unknown, strict=True)))
    matrix = spin.jacobian(unknown)
    determinant = reduce_sines(matrix.det())
    return (matrix.adjugate().applyfunc(reduce_sines) / determinant).applyfunc(sp.cancel) * sp.Matrix(omega)


def quaternion_product(a: Sequence[sp.Expr], b: Sequence[sp.Expr]) -> sp.Matrix:
    """Return the product of two quaternions.

    Parameters
    ----------
    a, b : sequence of Expr
        Four components, scalar first.
    """
    (a_0, *a_v), (b_0, *b_v) = expressions("a", a, 4), expressions("b", b, 4)
    u, v = sp.Matrix(a_v), sp.Matrix(b_v)
    return sp.Matrix([a_0 * b_0 - u.dot(v), *(a_0 * v + b_0 * u + u.cross(v))])


def quaternion_rotation(q: Sequence[sp.Expr]) -> sp.Matrix:
    """Return the matrix of v -> q* v q for a unit quaternion: it transforms components into the rotated frame.

    Parameters
    ----------
    q : sequence of Expr
        Four components, scalar first.
    """
    a, b, c, d = expressions("q", q, 4)
    conjugate = (a, -b, -c, -d)
    columns = []
    for axis in range(3):
        unit = (0, *(1 if axis is k else 0 for k in range(3)))
        turned = quaternion_product(quaternion_product(conjugate, unit), q)
        columns.append(turned[1:, 0].applyfunc(sp.expand))
    return sp.Matrix.hstack(*columns)


def quaternion_rates(q: Sequence[sp.Expr], omega: Sequence[sp.Expr]) -> sp.Matrix:
    """Return q' = q (0, Omega)/2 for the angular velocity Omega of the rotated frame, in its own axes.

    Parameters
    ----------
    q : sequence of Expr
        Four components of a unit quaternion, scalar first.
    omega : sequence of Expr
        Rate of the frame, rad/s.
    """
    rate = expressions("omega", omega, 3)
    return quaternion_product(expressions("q", q, 4), (sp.S.Zero, *rate)) / 2


def quaternion_of_turns(turns: Sequence[tuple[int, sp.Expr]]) -> sp.Matrix:
    """Return the unit quaternion of successive rotations.

    Parameters
    ----------
    turns : sequence of (int, Expr)
        Axis 0, 1 or 2 and angle, rad, of each.
    """
    if not isinstance(turns, tuple | list) or not all(map(_is_turn, turns)):
        raise wrong("turns", turns, "a tuple of axes 0, 1 or 2 with their angles, as in ((2, yaw), (0, roll))")
    total = sp.Matrix([1, 0, 0, 0])
    for axis, angle in turns:
        single = [sp.cos(angle / 2), 0, 0, 0]
        single[axis + 1] = sp.sin(angle / 2)
        total = quaternion_product(total, single)
    return total


def _is_turn(turn: object) -> bool:
    if not isinstance(turn, tuple | list) or len(turn) != 2:
        return False
    axis, angle = turn
    return type(axis) is int and axis in (0, 1, 2) and isinstance(angle, sp.Expr | int | float)


def kirchhoff(
    energy: sp.Expr,
    velocity: sp.Matrix,
    rate: sp.Matrix,
    rates: Mapping[sp.Symbol, sp.Expr],
) -> tuple[sp.Matrix, sp.Matrix]:
    """Return the left sides of Kirchhoff's equations for a kinetic energy in quasi-velocities.

    Parameters
    ----------
    energy : Expr
        Kinetic energy T(V, Omega, q, q'), J.
    velocity, rate : sympy.Matrix
        Velocity V of the reference point, m/s, and rate Omega of the axes, rad/s, both in those axes.
    rates : mapping of Symbol to Expr
        Time derivatives of V, Omega, q and q'.

    Returns
    -------
    force, moment : sympy.Matrix
        d/dt(dT/dV) + Omega x dT/dV, N, and d/dt(dT/dOmega) + Omega x dT/dOmega + V x dT/dV, N m.
    """
    total, v, w = expression("energy", energy), symbols("velocity", velocity, 3), symbols("rate", rate, 3)
    linear, angular = (sp.Matrix(gradient(total, group)) for group in (v, w))
    force = matrix_rate(linear, rates) + sp.Matrix(w).cross(linear)
    moment = matrix_rate(angular, rates) + sp.Matrix(w).cross(angular) + sp.Matrix(v).cross(linear)
    return force, moment


def lagrange(
    energy: sp.Expr,
    dissipation: sp.Expr,
    coordinates: Sequence[sp.Symbol],
    speeds: Sequence[sp.Symbol],
    rates: Mapping[sp.Symbol, sp.Expr],
) -> sp.Matrix:
    """Return d/dt(dT/dq') - dT/dq + dR/dq' for a kinetic energy T and a Rayleigh function R.

    Parameters
    ----------
    energy, dissipation : Expr
        T and R, as functions of coordinates and speeds.
    coordinates, speeds : sequence of Symbol
        q and q', in the same order.
    rates : mapping of Symbol to Expr
        Time derivative of each symbol that depends on time, as for `time_derivative`.
    """
    q = symbols("coordinates", coordinates)
    kinetic, lost, slopes = expression("energy", energy), expression("dissipation", dissipation), _Slopes()
    rows = [
        time_derivative(slopes(kinetic, speed), rates) - slopes(kinetic, coordinate) + slopes(lost, speed)
        for coordinate, speed in zip(q, symbols("speeds", speeds, len(q)), strict=True)
    ]
    return sp.Matrix(rows)
