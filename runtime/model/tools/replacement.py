# SPDX-License-Identifier: Apache-2.0
"""Generated Python code with another library in place of NumPy."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from types import FunctionType, ModuleType
from typing import Any

from mehvar.base.errors import InputError, unknown_name
from mehvar.base.manifest import Manifest
from mehvar.base.names import identifier

from ..functions import PythonBackend


def with_globals(function: Callable[..., Any], **names: object) -> FunctionType:
    """Return a function with replaced global names, also in the functions that it calls.

    Parameters
    ----------
    function : callable
        Function of the generated module.
    **names
        Replacements of all names that generated functions use, such as `np`, `_arrays` and `_vector`.
    """
    assert isinstance(function, FunctionType)
    space = {**function.__globals__, **names}
    for name, other in function.__globals__.items():
        if isinstance(other, FunctionType) and name not in names:
            space[name] = FunctionType(other.__code__, space, name)
    return FunctionType(function.__code__, space, function.__name__)


def library(name: str, package: str, use: str) -> ModuleType:
    """Import the library of a conversion, or raise InputError with its install command."""
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as error:
        raise InputError(f"{use} needs {package}: pip install {package}") from error


class Translation:
    """Generated functions for another library, each converted at first use.

    Parameters
    ----------
    manifest : Manifest
        Of the model.
    translate : callable
        Converts a function, given its name and the generated Python function.
    """

    def __init__(self, manifest: Manifest, translate: Callable[[str, Callable[..., Any]], Any]) -> None:
        self._names = {identifier(name): name for name in manifest.whole.functions}
        self._module, self._translate, self._model = PythonBackend(manifest), translate, manifest.model

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):  # names that copy and pickle look up
            raise AttributeError(name)
        if name not in self._names:
            raise AttributeError(str(unknown_name(f"function of {self._model}", name, self._names)))
        function = self._translate(self._names[name], self._module.raw(name))
        setattr(self, name, function)
        return function

    def __dir__(self) -> list[str]:
        return sorted(self._names)
