# SPDX-License-Identifier: Apache-2.0
"""Names in code and in print."""

import pytest

from mehvar.base.names import typeset


@pytest.mark.parametrize(
    ("name", "latex"),
    [
        ("m", "m"),
        ("mass", r"\mathrm{mass}"),
        ("theta_dot", r"\dot{\theta}"),
        ("theta_ddot", r"\ddot{\theta}"),
        ("phi1_dot", r"\dot{\phi}_{1}"),
        ("k_energy", r"k_{\mathrm{energy}}"),
        ("K_1_2", "K_{1,2}"),
        ("I_x", "I_{x}"),
        ("Omega_0", r"\Omega_{0}"),
    ],
)
def test_a_name_without_latex_is_typeset(name, latex):
    assert typeset(name) == latex
