# SPDX-License-Identifier: Apache-2.0
"""Derive spacecraft attitude models, generate code from them, and simulate them.

Importing and running generated models needs numpy and scipy; SymPy and CasADi are loaded only to derive and generate.
"""

from __future__ import annotations

import importlib
import importlib.util
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from codegen.lower import to_casadi as to_casadi
    from mehvar.api import batch as batch
    from mehvar.api import simulate as simulate
    from mehvar.diffing import diff as diff
    from models.mechanics import kirchhoff as kirchhoff
    from models.mechanics import lagrange as lagrange
    from models.mechanics import time_derivative as time_derivative
    from models.system import Condition as Condition
    from models.system import Controller as Controller
    from models.system import Coordinates as Coordinates
    from models.system import Derivation as Derivation
    from models.system import Function as Function
    from models.system import Group as Group
    from models.system import Metric as Metric
    from models.system import ModelError as ModelError
    from models.system import Output as Output
    from models.system import Parameter as Parameter
    from models.system import Quantity as Quantity
    from models.system import Scenario as Scenario
    from models.system import System as System
    from models.tables import read_parameters as read_parameters
    from models.tables import read_scenarios as read_scenarios
    from runtime.errors import InputError as InputError
    from runtime.model import Model as Model
    from runtime.model import load as load
    from runtime.results import open_result as open_result

__version__ = version("mehvar")

_HOMES = {
    "mehvar.api": ("batch", "simulate"),
    "mehvar.diffing": ("diff",),
    "runtime.errors": ("InputError",),
    "runtime.model": ("Model", "load"),
    "runtime.results": ("open_result",),
    "codegen.lower": ("to_casadi",),
    "models.mechanics": ("kirchhoff", "lagrange", "time_derivative"),
    "models.tables": ("read_parameters", "read_scenarios"),
    "models.system": (
        "Condition", "Controller", "Coordinates", "Derivation", "Function", "Group", "Metric", "ModelError",
        "Output", "Parameter", "Quantity", "Scenario", "System",
    ),
}  # fmt: skip
_HOME = {name: home for home, names in _HOMES.items() for name in names}
__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    if name in _HOME:
        try:
            return getattr(importlib.import_module(_HOME[name]), name)
        except Exception:
            _require_own_packages()
            raise
    raise AttributeError(f"module 'mehvar' has no attribute {name!r}")


def _require_own_packages() -> None:
    """Raise ImportError when a package of the user's comes before one of ours on the path."""
    for package in ("models", "codegen", "runtime"):
        own = Path(__file__).parents[1] / package / "__init__.py"
        found = importlib.util.find_spec(package)
        if found and found.origin and not own.samefile(found.origin):
            raise ImportError(
                f"{found.origin} hides mehvar's package {package}: rename that folder, or start Python with -P"
            )


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
