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
        ("1.6 m/s^2, 10^-3, F(0) = 10^4.", "1.6 m/s², 10⁻³, F(0) = 10⁴."),
        ("5 deg at 2 deg/s, degrees", "5° at 2°/s, degrees"),
        ("87000 rpm, 4618 m/s, 0.00012345", "87\u202f000 rpm, 4618 m/s, 0.00012345"),
        ("w_3 and r_10", "w<sub>3</sub> and r<sub>10</sub>"),
        ("phi_1 < v_y, delta_2", "φ<sub>1</sub> &lt; v<sub>y</sub>, δ<sub>2</sub>"),
    ],
)
def test_texts_are_set_with_minus_signs_powers_degrees_and_subscripts(plain, pretty):
    assert str(typeset(plain)) == pretty
