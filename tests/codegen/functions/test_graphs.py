# SPDX-License-Identifier: Apache-2.0
"""Equal parts have equal graphs, whatever the names of shared subexpressions."""

import sympy as sp

from mehvar import Group, Quantity, System
from mehvar.codegen.code.files import printed_functions
from mehvar.codegen.functions.function import LEAST
from mehvar.codegen.functions.graphs import generate_functions


def equal_parts(count: int) -> System:
    """Parts with rates of three subexpressions each, which are numbered across 9 and 10."""
    x = Group("x", tuple(Quantity(f"x{k}", "1", "state", family="part", index=k) for k in range(1, count + 1)))
    products = [(sp.sin(s) * sp.cos(s), sp.cos(s) * sp.tan(s), sp.sin(s) * sp.tan(s)) for s in x.symbols]
    rates = tuple(sp.sin(sum(each)) + sum(a**2 for a in each) for each in products)
    return System(name="parts", states=x, rhs=rates)


def test_the_text_of_equal_parts_does_not_grow() -> None:
    """SymPy orders terms by name, and cse_10 comes before cse_9: parts differed, and were in no loop."""
    sizes = []
    for count in (LEAST, LEAST + 3):
        functions = [f for f in generate_functions(equal_parts(count)) if f.name == "rhs"]
        sizes.append(len(printed_functions(functions)[0].c_lines))
    assert sizes[0] == sizes[1] < 30
