# SPDX-License-Identifier: Apache-2.0
"""A paper about the cart, with a misprint: its (2) has the wrong sign."""

from mehvar.models.paper import Erratum, ErratumKind, Names, Paper, Printed, Reading, Relation, insert_definitions
from mehvar.models.system import System


def paper(system: System) -> Paper:
    names = Names()
    own = {q.symbol: names.free(q) for q in (*system.states, *system.inputs)}
    own |= {q.symbol: names.free(q, 1, 2) for q in system.parameters}
    x, v, force, mass, k, d = own.values()
    symbols = {symbol.name: symbol for symbol in system.definitions}
    spring = names.derived("F_s", "F_s", insert_definitions(symbols["spring"], system.definitions, own))
    rate = names.derived("v_dot", r"\dot v", insert_definitions(symbols["v_dot"], system.definitions, own))
    wrong = Relation(rate, (spring - force) / mass, corrected=(spring + force) / mass)
    return Paper(
        "The cart: a paper that nobody wrote",
        2,
        names,
        (
            Printed("1", "force of the spring", "equation", (Reading((Relation(spring, -d * v - k * x),)),)),
            Printed("2", "acceleration", "equation", (Reading((wrong,)),)),
        ),
        errata={"2": Erratum(ErratumKind.MISPRINT, "The force pushes.", assumption=True)},
    )
