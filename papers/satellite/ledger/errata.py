# SPDX-License-Identifier: Apache-2.0
"""Errata of the satellite's paper with kind and cause; the verdicts themselves are computed."""

from __future__ import annotations

from collections.abc import Mapping

from mehvar.ledger import Erratum, ErratumKind

SCAN, NOTATION, MISPRINT, PHYSICS = ErratumKind.SCAN, ErratumKind.NOTATION, ErratumKind.MISPRINT, ErratumKind.PHYSICS

ERRATA: Mapping[str, Erratum] = {
    "1": Erratum(SCAN, "The bars over the vectors were read as dots, with one too many over T."),
    "2": Erratum(SCAN, "The bar over a vector was read as a dot."),
    "3": Erratum(NOTATION, "The axes of the orbit are not defined, and the sign of omega_0 depends on them."),
    "4": Erratum(SCAN, "The bar over a vector was read as a dot."),
    "text on (3)": Erratum(NOTATION, "The arrows can mean the order of the factors or the order of the turns."),
    "text on (4)": Erratum(NOTATION, "It is not said relative to which axes the body rates are."),
    "text before (8)": Erratum(
        PHYSICS,
        "The gravity gradient, which (8) and (9) contain, is in none of the equations that they are to follow from.",
    ),
    "8": Erratum(SCAN, "One of the two dots of the second derivative is lost."),
    "9": Erratum(SCAN, "One of the two dots of the second derivative is lost."),
    "10": Erratum(SCAN, "One of the two dots of the second derivative is lost."),
    "11": Erratum(SCAN, "The dots over the last three entries are lost."),
    "text before (12)": Erratum(
        PHYSICS, "The zero of the sampled plant lies at -1, on the unit circle and not inside it."
    ),
    "19": Erratum(NOTATION, "One letter n is the order of three polynomials, and is explained nowhere."),
    "23": Erratum(NOTATION, "One letter n is the order of three polynomials, and is explained nowhere."),
    "24": Erratum(NOTATION, "One letter n is the order of three polynomials, and is explained nowhere."),
    "30": Erratum(MISPRINT, "Two entries of the row have become a sum, and the index of b is n_s for n_B."),
    "34": Erratum(
        MISPRINT,
        "The estimate of this sample is printed for that of the sample before, from which (39) and (42) predict.",
    ),
    "36": Erratum(NOTATION, "One letter is a row here and in (34), and a column in (40) to (42)."),
    "text after (38)": Erratum(PHYSICS, "The law (32) has no term that takes the estimated offset off."),
    "Table 1, I_omega": Erratum(
        NOTATION, "It is not said whether the numbers are three wheels' or three axes' of one wheel."
    ),
    "43": Erratum(PHYSICS, "The printed b_0 belongs to no way of sampling the axis, for all of which B(1) is T_s^2/I."),
    "44": Erratum(PHYSICS, "The printed b_0 belongs to no way of sampling the axis, for all of which B(1) is T_s^2/I."),
    "45": Erratum(PHYSICS, "The printed b_0 belongs to no way of sampling the axis, for all of which B(1) is T_s^2/I."),
    "text after (45)": Erratum(
        NOTATION, "It is not said whether d counts the delay of the link, for which the text before (49) designs."
    ),
    "text before (49)": Erratum(
        PHYSICS, "The design that is printed, (47) and (48), is for d = 1, without the delay of the link."
    ),
    "text before (49), amount of data": Erratum(
        MISPRINT,
        "Bits are printed where bytes must be meant, since 12 bits do not hold three torques.",
        assumption=True,
    ),
    "text before (49), sampling time": Erratum(MISPRINT, "The least sampling time is printed for the greatest."),
}
