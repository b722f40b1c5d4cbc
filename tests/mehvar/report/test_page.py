# SPDX-License-Identifier: Apache-2.0
import pytest

from mehvar.report.page import typeset


@pytest.mark.parametrize(
    ("plain", "pretty"),
    [
        ("2.7e-10 rad", "2.7×10⁻¹⁰ rad"),
        ("from -1 to -0.5", "from −1 to −0.5"),
        ("paper-b, 5-6, l-1, torque_lost", "paper-b, 5-6, l-1, torque_lost"),
        ("R + 9e-11", "R + 9×10⁻¹¹"),
        ("phi_1 < v_y, delta_2", "φ<sub>1</sub> &lt; v<sub>y</sub>, δ<sub>2</sub>"),
    ],
)
def test_texts_are_set_with_minus_signs_powers_and_subscripts(plain, pretty):
    assert str(typeset(plain)) == pretty
