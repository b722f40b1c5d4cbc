# SPDX-License-Identifier: Apache-2.0
"""Forms in which a system may be declared, and their conversion before generation.

Mass matrices, `mass` x' = `rhs`, and laws that command once in several samples.
"""

from .mass import algebraic_rows, has_rates, mass_rows, with_mass
from .samples import with_samples

__all__ = ["algebraic_rows", "has_rates", "mass_rows", "with_mass", "with_samples"]
