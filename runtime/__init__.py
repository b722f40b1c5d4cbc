# SPDX-License-Identifier: Apache-2.0
"""Compiles generated models and runs them; needs NumPy, and SciPy only without a compiler."""

from .errors import BuildError, InputError
from .manifest import Manifest, find_model, known_models, read_manifest
from .metrics import metrics
from .model import Model, load
from .problem import Status
from .results import open_result, save, to_dataset
from .simulate import Run, simulate

__all__ = [
    "BuildError",
    "InputError",
    "Manifest",
    "Model",
    "Run",
    "Status",
    "find_model",
    "known_models",
    "load",
    "metrics",
    "open_result",
    "read_manifest",
    "save",
    "simulate",
    "to_dataset",
]
