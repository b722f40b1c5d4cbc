# SPDX-License-Identifier: Apache-2.0
"""Kinematics of three planar masses with rods of variable length, equations (1)-(28).

Vertices 1, 2, 3 run counter-clockwise and rod k lies opposite vertex k. The position of mass i is X_i = Q S x_i (5):
a fixed base triangle x_i, a symmetric positive stretch S, and a rotation Q by theta. The shape is zeta = rho exp(i
phi), the size mu. zeta is regular everywhere; the paper's polar pair (rho, phi) is singular at rho = 0.
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from ..derivation import vector
from ..mechanics import QUARTER_TURN, matrix_rate, planar_cross, rotate, time_derivative
from ..system import Derivation, Expr, Quantity

RHO = Quantity("rho", "1", "distance from the base shape in the shape disc", r"\rho")
PHI = Quantity("phi", "rad", "direction in the shape disc", r"\varphi")
MU = Quantity("mu", "m^2", "size: three times the mean square radius of gyration", r"\mu", positive=True)
THETA = Quantity("theta", "rad", "attitude, counter-clockwise", r"\theta")
W1 = Quantity("w1", "1/s", "rate of rho", "w_1")
W2 = Quantity("w2", "rad/s", "rate of phi", "w_2")
W3 = Quantity("w3", "m^2/s", "rate of mu", "w_3")
ZETA1 = Quantity("zeta1", "1", "rho cos(phi)", r"\zeta_1")
ZETA2 = Quantity("zeta2", "1", "rho sin(phi)", r"\zeta_2")
ZETA1_RATE = Quantity("zeta1_rate", "1/s", "rate of rho cos(phi)", r"\zeta_1'")
ZETA2_RATE = Quantity("zeta2_rate", "1/s", "rate of rho sin(phi)", r"\zeta_2'")
LENGTHS = tuple(Quantity(f"l{k}", "m", f"length of rod {k}", f"l_{k}", positive=True) for k in (1, 2, 3))
RATES = tuple(Quantity(f"u_l{k}", "m/s", f"rate of rod {k}", f"u_{k}") for k in (1, 2, 3))

zeta = sp.Matrix([ZETA1.symbol, ZETA2.symbol])
zeta_rate = sp.Matrix([ZETA1_RATE.symbol, ZETA2_RATE.symbol])
mu, mu_rate = MU.symbol, W3.symbol


@dataclass(frozen=True)
class BaseTriangle:
    """The triangle x_i of (2), scaled to sum m_i x_i x_i^T = (mbar/2) I.

    Attributes
    ----------
    mean_mass : Expr
        mbar, kg.
    length_squared : tuple of Expr
        Squared edge lengths L_k^2; dimensionless.
    cosine, sine : tuple of Expr
        Cosine and sine of twice the direction angle of each edge; edge 3 points along +x.
    direction : tuple of (Expr, Expr)
        Cosine and sine of that angle itself, for the edge d_k.
    """

    mean_mass: Expr
    length_squared: tuple[Expr, Expr, Expr]
    cosine: tuple[Expr, Expr, Expr]
    sine: tuple[Expr, Expr, Expr]
    direction: tuple[tuple[Expr, Expr], ...]


def base_triangle(masses: tuple[Expr, Expr, Expr], d: Derivation) -> BaseTriangle:
    """Return the base triangle of three masses, which (2) and (13) determine up to a rotation.

    With sum m_i x_i = 0 and sum m_i x_i x_i^T = (mbar/2) I the rows sqrt(m_i) x_i are orthogonal to
    (sqrt(m_1), sqrt(m_2), sqrt(m_3)), hence x_i . x_j = (mbar/2)(delta_ij/m_i - 1/M).
    """
    equal = len(set(masses)) == 1
    total = sp.Add(*masses)
    mean = masses[0] if equal else d.define("mbar", total / 3, "(13)", "mean mass", "kg", r"\bar m", True)

    def dot(i: int, j: int) -> Expr:
        own = 1 / masses[i] if i is j else sp.S.Zero
        return (mean / 2) * (own - 1 / (3 * mean))

    def edge_dot(k: int, n: int) -> Expr:
        (i, j), (a, b) = _ends(k), _ends(n)
        return sp.expand(dot(j, b) - dot(j, a) - dot(i, b) + dot(i, a))

    lengths, directions, double = [], [], {name: list[Expr]() for name in _SPELLED}
    for k in range(3):
        squared = edge_dot(k, k)
        along = edge_dot(2, k) / sp.sqrt(squared * edge_dot(2, 2))
        across = {0: 1, 1: -1, 2: 0}[k] * sp.sqrt(1 - along**2)
        directions.append((along, across))
        cosine, sine = sp.simplify(2 * along**2 - 1), sp.simplify(2 * along * across)
        lengths.append(_name(d, f"L{k + 1}_sq", squared, f"squared base edge {k + 1}", f"L_{k + 1}^2", True))
        for name, value in (("cos", cosine), ("sin", sine)):
            title = f"{_SPELLED[name]} of twice the direction of edge {k + 1}"
            double[name].append(_name(d, f"edge_{name}{k + 1}", value, title, rf"\{name} 2\epsilon_{k + 1}"))
    return BaseTriangle(mean, tuple(lengths), tuple(double["cos"]), tuple(double["sin"]), tuple(directions))


_SPELLED = {"cos": "cosine", "sin": "sine"}


def _name(d: Derivation, name: str, expr: Expr, title: str, latex: str, positive: bool = False) -> Expr:
    """Define a quantity of the base triangle unless it is a number, as it is for equal masses."""
    return expr if expr.is_number else d.define(name, expr, "(15)", title, "1", latex, positive)


def _ends(k: int) -> tuple[int, int]:
    """Vertices i, j of edge k, with (i, j, k) an even permutation and d_k = x_j - x_i (14)."""
    return (k + 1) % 3, (k + 2) % 3


def stretch(d: Derivation) -> sp.Matrix:
    """Return S from shape and size (Table 1).

    S = sqrt(mu/3) [[n + zeta1, -zeta2], [-zeta2, n - zeta1]] with n^2 = 1 - |zeta|^2.
    """
    n = d.define(
        "n",
        sp.sqrt(1 - zeta.dot(zeta)),
        "(19)",
        "complement of rho: rho^2 + n^2 = 1",
        latex="n",
        positive=True,
    )
    sigma = d.define(
        "sigma_mu", sp.sqrt(mu / 3), "(18)", "root of Ibar", unit="m", latex=r"\sqrt{\bar I}", positive=True
    )
    return sigma * sp.Matrix([[n + zeta[0], -zeta[1]], [-zeta[1], n - zeta[0]]])


def attitude_rate(stretch_matrix: sp.Matrix, base: BaseTriangle, momentum: Expr, d: Derivation) -> Expr:
    """Solve the angular momentum H = sum m_i X_i x X_i' (7) for theta', as in (10), (11) and (21).

    Returns
    -------
    Expr
        theta' in the regular coordinates, without disturbance.
    """
    theta, theta_rate = THETA.symbol, sp.Symbol("theta_rate")
    entries = sp.symbols("S_11 S_12 S_22")
    changes = sp.symbols("S_11' S_12' S_22'")
    s = sp.Matrix([[entries[0], entries[1]], [entries[1], entries[2]]])
    balance = _momentum_over_mean_mass(s, {theta: theta_rate, **dict(zip(entries, changes, strict=True))})
    inertia, shape_term = balance.coeff(theta_rate, 1), balance.coeff(theta_rate, 0)

    matrix = stretch_matrix.subs(d.definitions)
    rate = matrix_rate(matrix, {zeta[0]: zeta_rate[0], zeta[1]: zeta_rate[1], mu: mu_rate})
    here = {e: m[k] for m, es in ((matrix, entries), (rate, changes)) for e, k in zip(es, (0, 1, 3), strict=True)}
    inertia, shape_term = (sp.simplify(expr.subs(here)) for expr in (inertia, shape_term))
    d.show(r"\bar I", inertia, "(11), (18)", "inertia of the stretched triangle over the mean mass", "m^2")
    d.show("t_s", shape_term, "(11)", "momentum of the change of shape over the mean mass", "m^2/s")
    return sp.expand((momentum / base.mean_mass - shape_term) / inertia)


def _momentum_over_mean_mass(s: sp.Matrix, rates: dict[sp.Symbol, sp.Symbol]) -> Expr:
    """Return the sum of X x X' over the masses for X = Q S x (5), where x has second moments mbar/2, mbar/2, 0 (13)."""
    x = sp.Matrix(sp.symbols("x_1 x_2"))
    theta = THETA.symbol
    turn = sp.cos(theta) * sp.eye(2) + sp.sin(theta) * QUARTER_TURN
    position = turn * s * x
    each = sp.expand(sp.trigsimp(sp.expand(planar_cross(position, matrix_rate(position, rates)))))
    return sp.expand((each.coeff(x[0], 2) + each.coeff(x[1], 2)) / 2)


def rod_lengths(stretch_matrix: sp.Matrix, base: BaseTriangle, d: Derivation) -> tuple[Expr, Expr, Expr]:
    """Return l_k from l_k^2 = d_k^T S^2 d_k (15), which gives (20)."""
    square = (stretch_matrix * stretch_matrix).applyfunc(sp.expand)
    trace = (square[0, 0] + square[1, 1]) / 2
    n, sigma = sp.Symbol("n", positive=True), sp.Symbol("sigma_mu", positive=True)
    trace = sp.simplify(trace.subs(n**2, 1 - zeta.dot(zeta)).subs(sigma**2, mu / 3))
    difference = sp.simplify((square[0, 0] - square[1, 1]).subs(sigma**2, mu / 3) / 2 / trace)
    shear = sp.simplify(square[0, 1].subs(sigma**2, mu / 3) / trace)
    stretched = [trace * (1 + difference * base.cosine[k] + shear * base.sine[k]) for k in range(3)]
    lengths = [sp.sqrt(square * by) for square, by in zip(base.length_squared, stretched, strict=True)]
    return tuple(vector("length*", lengths, "length of rod *", "m", "l_*", d, "(20)", "123", positive=True))


def rod_rates(lengths: tuple[Expr, ...], d: Derivation) -> tuple[Expr, ...]:
    """Differentiate (20) along a motion, which gives (22) without singularity."""
    definitions = d.definitions
    n = sp.Symbol("n", positive=True)
    rates = {zeta[0]: zeta_rate[0], zeta[1]: zeta_rate[1], mu: mu_rate, n: -zeta.dot(zeta_rate) / n}
    changes = [time_derivative(definitions[length] ** 2, rates) / (2 * length) for length in lengths]
    return tuple(vector("rod_rate*", changes, "rate of rod *", "m/s", "u_*", d, "(22)", "123"))


def polar_rate(theta_rate: Expr, d: Derivation) -> Expr:
    """Return theta' in the paper's chart zeta = rho exp(i phi): (21), (23)."""
    rho, phi, rho_rate, phi_rate = RHO.symbol, PHI.symbol, W1.symbol, W2.symbol
    polar = sp.Matrix([rho * sp.cos(phi), rho * sp.sin(phi)])
    rate = matrix_rate(polar, {rho: rho_rate, phi: phi_rate})
    in_polar = dict(zip((*zeta, *zeta_rate), (*polar, *rate), strict=True))
    result = sp.trigsimp(sp.expand(theta_rate.subs(in_polar, simultaneous=True)))
    d.show(r"\theta'", result, "(21), (23)", "attitude rate in the paper's chart", "rad/s")
    return result


def target_lengths(lengths: tuple[Expr, ...], rho: Expr, phi: Expr, size: Expr, d: Derivation) -> tuple[Expr, ...]:
    """Return the rod lengths of a target shape by (20)."""
    definitions = d.definitions
    goal = {
        zeta[0]: rho * sp.cos(phi),
        zeta[1]: rho * sp.sin(phi),
        mu: size,
        sp.Symbol("n", positive=True): sp.sqrt(1 - rho**2),
    }
    final = [definitions[length].subs(goal, simultaneous=True) for length in lengths]
    return tuple(vector("length*_ref", final, "final length of rod *", "m", "l_{*,f}", d, "(20)", "123"))


def shape_from_lengths(
    lengths: tuple[Expr, Expr, Expr], base: BaseTriangle, d: Derivation, suffix: str
) -> tuple[Expr, Expr, Expr, Expr]:
    """Invert (20): solve (15) for S^2 as in (17), then for mu, rho and phi as in (18), (19).

    Parameters
    ----------
    lengths : tuple of Expr
        l_1, l_2, l_3.
    base : BaseTriangle
        Base triangle.
    d : Derivation
        Receives the steps.
    suffix : str
        Suffix of the names of the steps, for derivations with several triangles.

    Returns
    -------
    tuple of Expr
        rho, phi, mu and the margin 1 - 4|z|^2, which is positive for a triangle that is not collinear.
    """
    z1, z2, size, margin = regular_shape(lengths, base, d, suffix)
    rho = sp.sqrt((z1**2 + z2**2) / complement_squared(margin))
    return rho, sp.atan2(z2, z1), size, margin


def complement_squared(margin: Expr) -> Expr:
    """Return n^2 = 1 - rho^2 from a triangle's margin (19)."""
    return (1 + sp.sqrt(sp.Max(margin, 0))) / 2


def regular_shape(
    lengths: tuple[Expr, ...], base: BaseTriangle, d: Derivation, suffix: str
) -> tuple[Expr, Expr, Expr, Expr]:
    """Return z = zeta sqrt(1 - rho^2), mu and margin; unlike `shape_from_lengths`, regular at rho = 0."""
    xx, yy, xy = sp.symbols("S_xx S_yy S_xy")
    trace = (xx + yy) / 2
    balance = [
        base.length_squared[k] * (trace + (xx - yy) / 2 * base.cosine[k] + xy * base.sine[k]) - lengths[k] ** 2
        for k in range(3)
    ]
    solution = sp.solve(balance, [xx, yy, xy], dict=True)[0]
    size = d.define(
        "mu" + suffix,
        sp.factor(sp.together(3 * trace.subs(solution))),
        "(18)",
        "size from the rod lengths",
        "m^2",
        rf"\mu_{{{suffix[1:]}}}",
        True,
    )
    z1 = sp.factor(3 * (xx - yy).subs(solution) / 4) / size
    z2 = sp.factor(-3 * xy.subs(solution) / 2) / size
    z1 = d.define("z1" + suffix, z1, "(19)", "rho sqrt(1 - rho^2) cos(phi)", latex=rf"z_{{1,{suffix[1:]}}}")
    z2 = d.define("z2" + suffix, z2, "(19)", "rho sqrt(1 - rho^2) sin(phi)", latex=rf"z_{{2,{suffix[1:]}}}")
    margin = d.define(
        "open" + suffix,
        1 - 4 * (z1**2 + z2**2),
        "(19)",
        "3 eta/mu^2: zero for collinear masses",
        latex=rf"3\eta/\mu^2_{{{suffix[1:]}}}",
    )
    return z1, z2, size, margin


def shifted_position(target_rho: Expr, target_phi: Expr) -> tuple[Expr, Expr]:
    """Return w = rho_f - zeta exp(-i phi_f) (25), the vector from current to target shape, rotated by -phi_f."""
    along, across = rotate((zeta[0], zeta[1]), sp.cos(target_phi), -sp.sin(target_phi))
    return target_rho - along, -across


def shifted_attitude(theta_error: Expr, a: Expr, w: tuple[Expr, Expr], factor: Expr) -> Expr:
    """Return the attitude (27) in the shifted chart, which fulfils (26).

    theta' = zeta x zeta' is rewritten with zeta = (a - w) exp(i phi_f). The remainder beyond w x w' is an exact
    derivative, whose antiderivative (27) adds to theta - theta_f.
    """
    w1, w2, w1_rate, w2_rate, shift = sp.symbols("w_1 w_2 w_1' w_2' a", real=True)
    position, velocity = sp.Matrix([shift - w1, -w2]), sp.Matrix([-w1_rate, -w2_rate])
    excess = sp.expand(planar_cross(position, velocity) - (w1 * w2_rate - w2 * w1_rate))
    potential = sp.integrate(excess.coeff(w1_rate), w1) + sp.integrate(excess.coeff(w2_rate), w2)
    return theta_error - factor * potential.subs({shift: a, w1: w[0], w2: w[1]}, simultaneous=True)
