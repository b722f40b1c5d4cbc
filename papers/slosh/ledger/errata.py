# SPDX-License-Identifier: Apache-2.0
"""Errata of the slosh paper with kind and cause; the verdicts themselves are computed."""

from __future__ import annotations

from collections.abc import Mapping

from mehvar.ledger import Erratum, ErratumKind

SCAN, NOTATION, MISPRINT, PHYSICS = ErratumKind.SCAN, ErratumKind.NOTATION, ErratumKind.MISPRINT, ErratumKind.PHYSICS

ERRATA: Mapping[str, Erratum] = {
    "1": Erratum(MISPRINT, "A dot stands over V in the derivative of L, which has no rate of V in it."),
    "2": Erratum(MISPRINT, "A dot stands over Omega in the derivative of L, which has no rate of Omega in it."),
    "3": Erratum(SCAN, "The dot over zeta is lost, and the dissipation (8) depends on the rates only."),
    "text after (7), omega_i": Erratum(SCAN, "One of the three entries of the column is lost."),
    "9": Erratum(
        MISPRINT, "The centripetal term has a minus between its squares for a plus, and stands in the wrong bracket."
    ),
    "10": Erratum(MISPRINT, "A Coriolis term has the wrong sign."),
    "11": Erratum(
        SCAN,
        "A line is lost after the square of theta_i', so that two terms run into one product, and two dots are lost.",
    ),
    "12": Erratum(MISPRINT, "The equation is printed in short, and what is left is not a part of the complete one."),
    "13": Erratum(MISPRINT, "The equation is printed in short, and what is left is not a part of the complete one."),
    "14": Erratum(MISPRINT, "The equation is printed in short, and what is left is not a part of the complete one."),
    "15": Erratum(
        PHYSICS, "The damping has the sign with which it drives the pendulum, and what else is printed is short."
    ),
    "16": Erratum(MISPRINT, "The equation is printed in short, and what is left is not a part of the complete one."),
    "25": Erratum(
        PHYSICS,
        "The damping has the sign with which it drives the pendulum, as in (15), and the factor m_i is missing.",
    ),
    "26": Erratum(
        PHYSICS, "The damping has the sign with which it drives the pendulum, and the factor m_i is missing."
    ),
    "27": Erratum(
        PHYSICS,
        "The products lack the terms that cancel the coupling of the pendulums' rates to Omega', so that (29)"
        " does not follow.",
    ),
    "text after (28), V_1": Erratum(
        SCAN, "The chain of inequalities stands in a line from right to left and can be read from either end."
    ),
    "text before (29)": Erratum(PHYSICS, "The form is claimed for the V_1 of (27), whose products do not give it."),
    "31": Erratum(MISPRINT, "The minus that (33) has is missing, and without it V_1 grows."),
    "32": Erratum(MISPRINT, "The minus that (33) has is missing, and without it V_1 grows."),
    "34": Erratum(MISPRINT, "The minus that (36) has is missing, and without it V_2 grows."),
    "35": Erratum(MISPRINT, "The minus that (36) has is missing, and without it V_2 grows."),
    "Table 1, lengths": Erratum(
        SCAN, "The stroke that is the decimal sign was read as a 1, or kept as a fraction.", assumption=True
    ),
    "Table 1, inertias": Erratum(
        NOTATION, "One letter is a moment of inertia in (5) and one per unit of mass in (26) and (27)."
    ),
    "Table 1, dampings": Erratum(
        SCAN, "The decimal sign was read as a stroke, and a digit is taken as lost.", assumption=True
    ),
    "Table 2, r_3, r_5, r_7": Erratum(
        SCAN, "The exponent is garbled: the text wants these weights far above 1.", assumption=True
    ),
    "Table 2, gains": Erratum(SCAN, "The exponents of the powers of ten are lost.", assumption=True),
}
