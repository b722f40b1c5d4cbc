# SPDX-License-Identifier: Apache-2.0
"""Identities that the values of the field obey exactly."""

import pytest

from mehvar.codegen.diff import compare
from mehvar.codegen.diff.report import EquationVerdict
from tests.codegen.diff.documents import document

SAME = [
    ("sin(a + atan2(y, z))", "(sin(a)*z + cos(a)*y)/sqrt(y**2 + z**2)"),
    ("cos(a - atan(x))", "(cos(a) + sin(a)*x)/sqrt(1 + x**2)"),
    ("sin(2*atan2(y, z))", "2*y*z/(y**2 + z**2)"),
    ("cos(a + pi/6)", "sqrt(3)/2*cos(a) - sin(a)/2"),
    ("tan(a/2)", "sin(a)/(1 + cos(a))"),
    ("exp(x + 2*y)", "exp(x)*exp(y)**2"),
]


@pytest.mark.parametrize(("one", "other"), SAME)
def test_an_identity_is_a_rearrangement_and_a_term_beside_it_is_none(one, other):
    same = compare(document(f"f: {one}"), document(f"f: {other}"))["f"]
    assert same.verdict is EquationVerdict.REARRANGED
    assert "of a 154-bit field" in same.how, "the field knows it, and no other engine is asked"
    assert compare(document(f"f: {one}"), document(f"f: {other} + x*sin(y)"))["f"].verdict is EquationVerdict.CHANGED
