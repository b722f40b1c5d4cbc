# SPDX-License-Identifier: Apache-2.0
"""Systems whose rates stand under a matrix: `mass` x' = `rhs`."""

from .mass import algebraic_rows, has_rates, mass_rows, with_mass

__all__ = ["algebraic_rows", "has_rates", "mass_rows", "with_mass"]
