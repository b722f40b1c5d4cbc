# SPDX-License-Identifier: Apache-2.0
import pytest

from mehvar.report.page import numerals, typeset


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


@pytest.mark.parametrize(
    ("cell", "shown"),
    [
        ("-0.5", "−0.5"), ("1e-05", "1×10⁻⁵"), ("1.5e-06 [-1e+20, 2]", "1.5×10⁻⁶ [−1×10²⁰, 2]"),
        ("[-1, -2.5]", "[−1, −2.5]"), ("2026-11-28", "2026-11-28"),
        ("--run 7", "--run 7"), ("3-4", "3-4"), ("-.5", "−.5"), ("kg m^2/s", "kg m²/s"),
    ],
)  # fmt: skip
def test_only_the_sign_of_a_number_is_a_minus(cell, shown):
    """Dates, ranges and options keep their hyphens."""
    assert numerals(cell) == shown
