# SPDX-License-Identifier: Apache-2.0
"""Places in a product or a sum that changed."""

import pytest

from mehvar.codegen.diff import compare
from mehvar.codegen.diff.report import Kind
from tests.codegen.diff.documents import document


@pytest.mark.parametrize(
    ("old", "new", "path"),
    [
        ("f: exp(x*sin(a))", "f: exp(x*y**2)", ("exp(x sin(a))", "sin(a)")),
        ("f: x*exp(y*sin(a))", "f: x*exp(y*w**2)", ("exp(y sin(a))", "sin(a)")),
        ("f: x*sin(a)", "f: x*sqrt(y**2 + 1)", ("sin(a)",)),
        ("f: x*m", "f: x*m*(y + z)", ()),
        ("f: sin(x*y)", "f: sin(x*y*exp(z)*cos(w))", ()),
    ],
)
def test_the_place_of_an_edit_is_the_innermost_that_explains_it(old, new, path):
    (equation,) = compare(document(old), document(new)).equations
    (edit,) = equation.edits
    assert edit.path == path


@pytest.mark.parametrize("after", ["2", "1", "3", "-1", "-2", "4", "-3", "1/2", "-1/2", "3/2"])
def test_another_exponent_is_an_edit_of_the_exponent(after):
    """The base is a length: its roots have values because it is positive."""
    (edit,) = compare(document("f: x*l**5 + y"), document(f"f: x*l**({after}) + y"))["f"].edits
    assert edit.kind is Kind.EXPONENT
    assert edit.says == f"exponent of l: 5 became {after}"
