# SPDX-License-Identifier: Apache-2.0
"""Values in messages."""

import numpy as np
import pytest

from mehvar.base.errors import MehvarError, value_text
from mehvar.parts import Hub, Spacecraft


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (np.float64(-3), "-3.0"),
        (np.float32(0.5), "0.5"),
        (np.int64(7), "7"),
        (np.bool_(True), "True"),
        (np.str_("a"), "'a'"),
        ((np.float64("nan"), [np.int8(1)]), "(nan, [1])"),
        ({"a": np.complex128(1 + 2j)}, "{'a': 1+2j}"),
    ],
)
def test_numbers_of_numpy_are_written_as_those_of_python(value, text):
    assert value_text(value) == text


def test_a_refused_number_of_numpy_is_shown_as_a_number():
    with pytest.raises(MehvarError, match=r"^m\.inertia = \[-3\.0, 1\.0\]: must be 3 numbers"):
        Spacecraft("a").add(Hub("m", mass=1.0, inertia=[np.float64(-3), 1.0]))
