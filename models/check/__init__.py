# SPDX-License-Identifier: Apache-2.0
"""What makes a model's text wrong, by subject; `whole` puts it together."""

from .branches import no_branching
from .formulas import formulas
from .whole import check

__all__ = ["check", "formulas", "no_branching"]
