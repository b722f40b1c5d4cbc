# SPDX-License-Identifier: Apache-2.0
"""Errata of the triangle's paper with kind and cause; the verdicts themselves are computed."""

from __future__ import annotations

from collections.abc import Mapping

from mehvar.ledger import Erratum, ErratumKind

SCAN, NOTATION, MISPRINT, PHYSICS = ErratumKind.SCAN, ErratumKind.NOTATION, ErratumKind.MISPRINT, ErratumKind.PHYSICS

ERRATA: Mapping[str, Erratum] = {
    "text after (9)": Erratum(MISPRINT, "The minus that (10) has is missing."),
    "text before (11)": Erratum(
        SCAN, "The m-bar that the words behind the formula explain was read as standing before it."
    ),
    "11": Erratum(SCAN, "The bar over the mean mass is lost."),
    "13": Erratum(
        MISPRINT,
        "The masses were left in place of the columns x_i when the condition before (11) was divided by the one mass.",
    ),
    "text after (18)": Erratum(MISPRINT, "The rate of theta is printed for that of S, which (18) needs."),
    "Table 1, row 3": Erratum(
        MISPRINT, "A plus joins two factors, although a number cannot be added to squares of lengths."
    ),
    "19": Erratum(MISPRINT, "The root over eta and the factor 1/2 are missing, without which rho is not that of (20)."),
    "22": Erratum(MISPRINT, "Differentiating (20) gives a minus before the last term."),
    "27": Erratum(
        PHYSICS, "The triangle under the path was counted once, and theta' is twice the area that is swept per second."
    ),
    "text before (28)": Erratum(
        SCAN, "The formula stands in a line from right to left, and the sign between R and sqrt(2)/2 is lost."
    ),
    "30": Erratum(MISPRINT, "The sign under the root is that of a sum, where (28) and (32) have the difference."),
    "32": Erratum(MISPRINT, "The last line defines g, which the line before it uses, and prints h once more."),
    "35": Erratum(MISPRINT, "The rate of rho~ is left out of the first line, and (32) has it."),
    "text before (36), rate of the attitude": Erratum(
        MISPRINT, "The two angles are exchanged, and (26) has them the right way round."
    ),
    "text before (36), slope of f": Erratum(
        MISPRINT, "The exponent has the sign of its reciprocal, and the constant factor is left out."
    ),
    "36": Erratum(NOTATION, "The equivalent rate is equated with the rate itself, which is so on the surface only."),
    "text after (36)": Erratum(MISPRINT, "The square is printed at sigma and belongs to rho~, as in (36)."),
    "text before (37)": Erratum(
        MISPRINT, "On the surface rho~ is f h, so that the quotient is f, for which h is printed."
    ),
    "38": Erratum(SCAN, "One of the angles has lost its tilde."),
    "text before (41)": Erratum(SCAN, "The words that define xi and alpha are lost."),
    "41": Erratum(SCAN, "The letter alpha was read as a, which is rho_f elsewhere."),
    "text after (41)": Erratum(
        SCAN, "The difference stands in a line from right to left and was read the other way round."
    ),
    "text after (42)": Erratum(SCAN, "The chain stands in a line from right to left and was read the other way round."),
    "44": Erratum(MISPRINT, "The factor v_2 is missing at the end, and (46) has it."),
    "text before (47)": Erratum(
        SCAN, "The inequality stands in a line from right to left and was read the other way round."
    ),
    "48": Erratum(
        PHYSICS,
        "The turn of (46) was inserted without its factor cos(xi/2), which is not negative, so that the "
        "conclusion stands.",
    ),
    "section 4, R": Erratum(MISPRINT, "A unit of length is printed behind a number that has none."),
    "section 4, k_phi": Erratum(SCAN, "The decimal sign of 0.5 is taken as lost.", assumption=True),
    "section 4, sliding mode": Erratum(
        MISPRINT, "A degree sign is printed behind a number of radians, which after (31) is above pi."
    ),
    "section 4, rod lengths": Erratum(
        SCAN, "The digits are garbled and one of the six numbers is lost.", assumption=True
    ),
    "52": Erratum(SCAN, "The dot over mu is lost."),
    "text after (52)": Erratum(MISPRINT, "The angle is printed where its neighbour, the sign of s, is replaced."),
    "53": Erratum(SCAN, "The bar over I is lost, and the superscript of t, which (12) has, is garbled."),
}
