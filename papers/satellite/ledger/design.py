# SPDX-License-Identifier: Apache-2.0
"""The design of the control law in the satellite's paper, (12)-(33), as printed."""

from __future__ import annotations

from collections.abc import Iterator

import sympy as sp

from mehvar.ledger import Case, Printed, Relation, printed

from .loop import DELAYS, SampledLoop

_OPEN = (
    "The orders of (19), (23) and (24) are 2, d - 1 and 1 here. Coefficients beyond the order are left free, since "
    "nothing says that they vanish."
)


def form(c: SampledLoop) -> Iterator[Printed]:
    """(12)-(16): plant and reference model."""
    model: tuple[Case, ...] = tuple(c.modelled(delay) for delay in DELAYS)
    yield printed(
        "text before (12)",
        "the plant is minimum phase",
        "condition",
        Relation(
            sp.Abs(c.b1 / c.b0),
            sp.S.One,
            "<",
            cases=c.sampled,
            says="the zero of B lies inside the unit circle, with B of the exactly sampled axis",
        ),
        note="b_0 = b_1 at any stiffness: the zero is at -1. A law that cancels it, (32), rings for ever. No "
        "correction of the sentence helps; the model's own law keeps the zero.",
    )
    q, d = c.q, c.d
    yield printed(
        "12",
        "transfer function",
        "definition",
        Relation(c.H, c.y / c.u, given=True),
        Relation(c.y / c.u, q**d * c.B / c.A, cases=c.sampled),
        note="Tested with the exactly sampled axis, with d = 1, and d = 2 for the link's delay.",
    )
    yield printed(
        "13",
        "difference equation",
        "equation",
        Relation(c.A * c.y, q**d * c.B * c.u, cases=c.sampled),
        Relation(d, sp.S.Zero, ">", cases=c.sampled),
        note="From rest; that y(0) is not zero is a condition.",
    )
    yield printed(
        "14",
        "B",
        "definition",
        Relation(c.B, c.b0 + c.b1 * q, says="with n_b = 1"),
        Relation(c.b0, sp.S.Zero, ">", cases=c.sampled, says="b_0 is not zero"),
        note="The last index is printed n_b here and n_B in (28).",
    )
    yield printed("15", "A", "definition", Relation(c.A, 1 + c.a1 * q + c.a2 * q**2, says="with n_a = 2"))
    yield printed("16", "reference model", "definition", Relation(c.C1 * c.y_m, q**d * c.D * c.r_k, cases=model))


def goals(c: SampledLoop) -> Iterator[Printed]:
    """(17)-(21): what the law must do, tested in the loop that it closes."""
    closed: tuple[Case, ...] = tuple(c.closed(delay) for delay in DELAYS)
    settling: tuple[Case, ...] = tuple(c.settling(delay) for delay in DELAYS)
    yield printed(
        "17",
        "tracking",
        "condition",
        Relation(c.C1 * c.y, c.q**c.d * c.D * c.r_k, cases=closed, says="under the law (32), from rest"),
    )
    yield printed(
        "18",
        "regulation",
        "condition",
        Relation(c.C2_y_ahead, sp.S.Zero, cases=settling, says="under the law (32) without reference, from any past"),
    )
    yield printed("19", "C2", "definition", Relation(c.C2, c.C2_to[c.n], corrected=c.C2_to[c.n_C2]), note=_OPEN)
    yield printed(
        "20",
        "error",
        "definition",
        Relation(c.e, c.y - c.y_m, given=True),
        note="Printed y(k), which is y_p(k) elsewhere.",
    )
    yield printed(
        "21",
        "error dynamics",
        "condition",
        Relation(c.C2_e_ahead, sp.S.Zero, cases=settling, says="under the law (32), from any past, for any y_m"),
    )


def equation(c: SampledLoop) -> Iterator[Printed]:
    """(22)-(26): the polynomial equation."""
    at = tuple(c.at.values())
    q, d = c.q, c.d
    yield printed("22", "polynomial equation", "equation", Relation(c.C2, c.A * c.S + q**d * c.T, cases=at))
    yield printed("23", "S", "definition", Relation(c.S, c.S_to[c.n], corrected=c.S_to[c.n_s], cases=at), note=_OPEN)
    yield printed("24", "T", "definition", Relation(c.T, c.T_to[c.n], corrected=c.T_to[c.n_t], cases=at), note=_OPEN)
    yield printed("25", "order of S", "equation", Relation(c.n_s, d - 1, cases=at))
    yield printed("26", "order of T", "equation", Relation(c.n_t, sp.Max(c.n_A - 1, c.n_C2 - d), cases=at))


def law(c: SampledLoop) -> Iterator[Printed]:
    """(27)-(33): regressors, parameters, the law."""
    last = {d: (c.u_1, c.u_2)[:d] for d in DELAYS}
    along = tuple(c.along.values())
    error = c.C2 * c.e_ahead
    model = c.C2 * c.y_m_ahead
    yield printed(
        "27",
        "error d samples ahead",
        "equation",
        Relation(error, c.B * c.S * c.u + c.T * c.y - model, cases=along),
        *(
            Relation(error, expr - model, cases=(c.along[d],), says=f"d = {d}")
            for d in DELAYS
            for expr in (c.b0 * c.u + c.p0_Phi0[d], c.p_Phi[d])
        ),
        note="Holds along (13); the text names (22)-(26) and (21) only.",
    )
    yield printed(
        "28",
        "regressors without u(k)",
        "definition",
        *(Relation(c.Phi0[d], sp.Matrix([[*last[d], c.y, c.y_1]]), says=f"d = {d}, n_B = n_T = 1") for d in DELAYS),
    )
    yield printed(
        "29",
        "regressors",
        "definition",
        *(
            Relation(c.Phi[d], sp.Matrix([[c.u, *(c.Phi0[d][0, i] for i in range(d + 2))]]), says=f"d = {d}")
            for d in DELAYS
        ),
    )
    yield _parameters(c)
    yield printed(
        "31",
        "parameters with b0",
        "definition",
        *(
            Relation(c.p[d], sp.Matrix([[c.b0, *(c.p0[d][0, i] for i in range(d + 2))]]), says=f"d = {d}")
            for d in DELAYS
        ),
    )
    one, two = along
    yield printed(
        "32",
        "the law",
        "equation",
        Relation(c.u_now, (model - c.T * c.y - c.BS * c.u) / c.b0, cases=(one, two)),
        note="Compared with the law mrac-literal at exact estimates, for the plant (13), which has no offset. With "
        "the offset d of (35) see the text after (38).",
    )
    yield printed(
        "33",
        "what the law knows of B S",
        "definition",
        Relation(c.BS, c.B * c.S - c.b0, cases=tuple(c.at.values())),
    )


def offset(c: SampledLoop) -> Printed:
    """Judge what the text after (38) says of the offset, against the law (32)."""
    law = (c.C2 * c.y_m_ahead - c.T * c.y - c.BS * c.u) / c.b0
    return printed(
        "text after (38)",
        "the estimate d(k) takes the effect of what the model lacks out of the loop",
        "statement",
        Relation(
            c.C2_e_offset,
            sp.S.Zero,
            cases=tuple(c.settling(delay) for delay in DELAYS),
            says="(21) with a constant offset d(k), under the model's law",
        ),
        Relation(
            c.u_offset,
            law,
            corrected=law - c.S_1 * c.offset / c.b0,
            cases=tuple(c.along.values()),
            says="the law that does this, against (32)",
        ),
        note="As printed (32) leaves C2 e = S(1) d.",
    )


def _parameters(c: SampledLoop) -> Printed:
    """(30): for d = 1 the last weight of the torques is the first, for d = 2 it is the second."""
    summed, last = c.b_ns * c.s_last + c.t_0, c.b_nB * c.s_last
    first = {1: [], 2: [c.b0 * c.s_1 + c.b1]}
    return printed(
        "30",
        "parameters",
        "definition",
        *(
            Relation(
                c.p0[d],
                sp.Matrix([[*first[d], summed, c.t_1]]),
                corrected=sp.Matrix([[*first[d], last, c.t_0, c.t_1]]),
                cases=(c.at[d],),
                says=f"d = {d}, n_B = n_T = 1, s_0 = 1",
            )
            for d in reversed(DELAYS)
        ),
        note="n_s is the order of S.",
    )
