# SPDX-License-Identifier: Apache-2.0
"""Calls of a C function at single points, without the cost of broadcasting."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import Any

import numpy as np

from mehvar.base.manifest import Function

_DOUBLE = np.dtype(np.float64)


class _Buffers:
    """Arrays for arguments and results of a call, at fixed addresses."""

    def __init__(self, function: Function) -> None:
        self.arguments = [np.empty(spec.shape) for spec in function.arguments]
        self.results = [np.empty(shape) for shape in function.shapes]
        self.addresses = _addresses(self.arguments), _addresses(self.results)


class Point:
    """Caller of a C function for arguments of exactly its shapes.

    Arguments are copied to arrays with known addresses, which costs less than reading the address of a NumPy array.
    Each call uses its own buffers, so that several threads may call at once.

    Parameters
    ----------
    function : Function
        Its arguments and results.
    entry : callable
        Returns the C function `void (const double *const *, double *const *)`; called once, at first use.
    """

    def __init__(self, function: Function, entry: Callable[[], Any]) -> None:
        self._function, self._entry = function, entry
        self._shapes = [spec.shape for spec in function.arguments]
        self._call: Any = None
        self._free: list[_Buffers] = []

    def __call__(self, arguments: tuple[Any, ...]) -> Any:
        """Return the results; None if an argument is neither a double nor an array of its shape."""
        if len(arguments) != len(self._shapes):
            return None
        for value, shape in zip(arguments, self._shapes, strict=True):
            if isinstance(value, np.ndarray):
                if value.dtype is not _DOUBLE or value.shape != shape:
                    return None
            elif not isinstance(value, float) or shape:
                return None
        try:
            buffers = self._free.pop()
        except IndexError:
            buffers = self._new()
        for buffer, value in zip(buffers.arguments, arguments, strict=True):
            buffer[...] = value
        self._call(*buffers.addresses)
        results = [result.copy()[()] for result in buffers.results]
        self._free.append(buffers)
        return results[0] if len(results) == 1 else tuple(results)

    def _new(self) -> _Buffers:
        if self._call is None:
            self._call = self._entry()
        return _Buffers(self._function)


def _addresses(arrays: list[Any]) -> Any:
    return (ctypes.c_void_p * len(arrays))(*[array.ctypes.data for array in arrays])
