# SPDX-License-Identifier: Apache-2.0
"""Derive spacecraft attitude models, generate code from them, and simulate them.

Importing and running generated models needs numpy and scipy; SymPy and CasADi are loaded only to derive and generate.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mehvar.api import batch as batch
    from mehvar.api import build as build
    from mehvar.api import open_result as open_result
    from mehvar.api import simulate as simulate
    from mehvar.base.errors import InputError as InputError
    from mehvar.base.errors import MehvarError as MehvarError
    from mehvar.base.errors import MissingError as MissingError
    from mehvar.codegen.functions.lower import to_casadi as to_casadi
    from mehvar.comparison.compare import diff as diff
    from mehvar.estimation.fit import Fit as Fit
    from mehvar.estimation.fit import fit as fit
    from mehvar.estimation.margins import Margin as Margin
    from mehvar.estimation.margins import margins as margins
    from mehvar.estimation.steer import Steering as Steering
    from mehvar.estimation.steer import SteeringError as SteeringError
    from mehvar.estimation.steer import steer as steer
    from mehvar.estimation.tune import Tuning as Tuning
    from mehvar.estimation.tune import tune as tune
    from mehvar.fmu.export import export_fmu as export_fmu
    from mehvar.models.estimation.estimated import estimated as estimated
    from mehvar.models.mechanics import kirchhoff as kirchhoff
    from mehvar.models.mechanics import lagrange as lagrange
    from mehvar.models.mechanics import quaternion_of_turns as quaternion_of_turns
    from mehvar.models.mechanics import quaternion_product as quaternion_product
    from mehvar.models.mechanics import quaternion_rates as quaternion_rates
    from mehvar.models.mechanics import quaternion_rotation as quaternion_rotation
    from mehvar.models.mechanics import time_derivative as time_derivative
    from mehvar.models.system import LARGEST as LARGEST
    from mehvar.models.system import TIME as TIME
    from mehvar.models.system import Actuator as Actuator
    from mehvar.models.system import Choice as Choice
    from mehvar.models.system import Condition as Condition
    from mehvar.models.system import Controller as Controller
    from mehvar.models.system import Coordinates as Coordinates
    from mehvar.models.system import Derivation as Derivation
    from mehvar.models.system import Diffusion as Diffusion
    from mehvar.models.system import Event as Event
    from mehvar.models.system import Function as Function
    from mehvar.models.system import Group as Group
    from mehvar.models.system import Metric as Metric
    from mehvar.models.system import ModelError as ModelError
    from mehvar.models.system import Output as Output
    from mehvar.models.system import Parameter as Parameter
    from mehvar.models.system import Quantity as Quantity
    from mehvar.models.system import RandomStep as RandomStep
    from mehvar.models.system import Scenario as Scenario
    from mehvar.models.system import Sensor as Sensor
    from mehvar.models.system import Shape as Shape
    from mehvar.models.system import System as System
    from mehvar.models.system import Variant as Variant
    from mehvar.models.system import scalar as scalar
    from mehvar.models.system import surfaces as surfaces
    from mehvar.models.tables import read_parameters as read_parameters
    from mehvar.models.tables import read_scenarios as read_scenarios
    from mehvar.report.verdicts import require as require
    from mehvar.runtime.batch.store.verification import verify as verify
    from mehvar.runtime.model.catalogue import list_models as list_models
    from mehvar.runtime.model.model import Model as Model
    from mehvar.runtime.model.model import load as load
    from mehvar.runtime.model.trim import Trim as Trim
    from mehvar.runtime.model.trim import TrimError as TrimError
    from mehvar.runtime.model.trim import trim as trim
    from mehvar.runtime.run.formats import save as save

_HOMES = {
    "mehvar.api": ("batch", "build", "open_result", "simulate"),
    "mehvar.comparison.compare": ("diff",),
    "mehvar.base.errors": ("InputError", "MehvarError", "MissingError"),
    "mehvar.estimation.fit": ("Fit", "fit"),
    "mehvar.estimation.margins": ("Margin", "margins"),
    "mehvar.estimation.steer": ("Steering", "SteeringError", "steer"),
    "mehvar.estimation.tune": ("Tuning", "tune"),
    "mehvar.fmu.export": ("export_fmu",),
    "mehvar.report.verdicts": ("require",),
    "mehvar.runtime.batch.store.verification": ("verify",),
    "mehvar.runtime.model.catalogue": ("list_models",),
    "mehvar.runtime.model.model": ("Model", "load"),
    "mehvar.runtime.model.trim": ("Trim", "TrimError", "trim"),
    "mehvar.runtime.run.formats": ("save",),
    "mehvar.codegen.functions.lower": ("to_casadi",),
    "mehvar.models.estimation.estimated": ("estimated",),
    "mehvar.models.mechanics": (
        "kirchhoff", "lagrange", "quaternion_of_turns", "quaternion_product", "quaternion_rates",
        "quaternion_rotation", "time_derivative",
    ),
    "mehvar.models.tables": ("read_parameters", "read_scenarios"),
    "mehvar.models.system": (
        "LARGEST", "TIME", "Actuator", "Choice", "Condition", "Controller", "Coordinates", "Derivation",
        "Diffusion", "Event", "Function", "Group", "Metric", "ModelError", "Output", "Parameter", "Quantity",
        "RandomStep", "Scenario", "Sensor", "Shape", "System", "Variant", "scalar", "surfaces",
    ),
}  # fmt: skip
_HOME = {name: home for home, names in _HOMES.items() for name in names}
_RESULTS = ("batch", "open_result", "simulate")
__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    if name in _RESULTS:
        importlib.import_module("mehvar.report.accessor")  # their datasets have `.mehvar`
    if name in _HOME:
        return getattr(importlib.import_module(_HOME[name]), name)
    if name == "__version__":
        return importlib.import_module("mehvar.base.versions").installed("mehvar")["mehvar"]
    raise AttributeError(f"module 'mehvar' has no attribute {name!r}")


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
