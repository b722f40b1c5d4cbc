# SPDX-License-Identifier: Apache-2.0
"""State as a Python law receives it: an array with named elements."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import Any

import numpy as np

from mehvar.base.errors import unknown_name

from ...model.functions import FloatArray


class State(np.ndarray[Any, np.dtype[np.float64]]):
    """State as a law's argument, shape (nx,), or (nx, runs) in a batch; read-only.

    `x.NAME` and `x["NAME"]` are a state or a reference, and `x.r` all references. A state with the name of an array
    attribute, such as `T`, replaces that attribute.

    Results of computations with it are plain arrays.
    """

    names: Sequence[str]
    references: Sequence[str]
    r: FloatArray

    def __getitem__(self, key: Any) -> Any:
        if not isinstance(key, str):
            return self.view(np.ndarray)[key]
        if key in self.names:
            return self.view(np.ndarray)[self.names.index(key)]
        if key in self.references:
            return self.r[self.references.index(key)]
        raise unknown_name("state or reference", key, (*self.names, *self.references))

    def __getattr__(self, name: str) -> Any:
        known = (*getattr(type(self), "names", ()), *getattr(type(self), "references", ()))
        raise AttributeError(f"unknown state or reference {name!r} of a law's argument; known: {', '.join(known)}")

    def __array_wrap__(self, array: Any, context: Any = None, return_scalar: bool = False) -> Any:
        plain = np.asarray(array)
        return plain[()] if return_scalar or plain.ndim == 0 else plain


@functools.cache
def state_type(names: tuple[str, ...], references: tuple[str, ...]) -> type[State]:
    """Return the state class of a model, with one property per name."""
    fields: dict[str, Any] = {"names": names, "references": references}
    fields |= {name: property(functools.partial(_reference, i)) for i, name in enumerate(references)}
    fields |= {name: property(functools.partial(_row, i)) for i, name in enumerate(names)}
    return type("State", (State,), fields)


def _row(i: int, state: State) -> Any:
    return state.view(np.ndarray)[i]


def _reference(i: int, state: State) -> Any:
    return state.r[i]
