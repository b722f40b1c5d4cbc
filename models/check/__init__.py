# SPDX-License-Identifier: Apache-2.0
"""Checks of a model, by subject; `all_checks` combines them."""

from .all_checks import check
from .branches import no_branching
from .formulas import formulas
from .kinds import check_kinds
from .tables import check_tables

__all__ = ["check", "check_kinds", "check_tables", "formulas", "no_branching"]
