# SPDX-License-Identifier: Apache-2.0
"""Compilation and simulation of generated models; needs NumPy and a C compiler."""

from mehvar.base.errors import BuildError, InputError
from mehvar.base.manifest import Manifest, read_manifest

from .model.catalogue import find_model, known_models, list_models
from .model.model import Model, load
from .run.formats import open_result, save
from .run.metrics import metrics
from .run.problem import Status
from .run.results import to_dataset
from .run.simulate import Run, simulate

__all__ = [
    "BuildError",
    "InputError",
    "Manifest",
    "Model",
    "Run",
    "Status",
    "find_model",
    "known_models",
    "list_models",
    "load",
    "metrics",
    "open_result",
    "read_manifest",
    "save",
    "simulate",
    "to_dataset",
]
