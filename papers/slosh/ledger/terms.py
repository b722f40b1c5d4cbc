# SPDX-License-Identifier: Apache-2.0
"""Products of sines and cosines that the slosh paper's equations are made of."""

from __future__ import annotations

import sympy as sp

from .symbols import Index


class Shorthand:
    """sin and cos of phi_i (s, c) and theta_i (S, C), and their products."""

    def __init__(self, i: Index) -> None:
        self.s, self.c = sp.sin(i.phi), sp.cos(i.phi)
        self.S, self.C = sp.sin(i.theta), sp.cos(i.theta)
        self.sS, self.sC = self.s * self.S, self.s * self.C
        self.cS, self.cC = self.c * self.S, self.c * self.C
