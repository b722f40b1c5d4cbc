# SPDX-License-Identifier: Apache-2.0
"""State as a Python law receives it: an array with named elements."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import Any

from mehvar.base.errors import unknown_name

from ...model.functions import FloatArray
from ...model.named import NamedVector


class State(NamedVector):
    """State as a law's argument, shape (nx,), or (nx, runs) in a batch; read-only.

    `x.NAME` and `x["NAME"]` are a state or a reference, and `x.r` all references. A state with the name of an array
    attribute, such as `T`, replaces that attribute.

    Results of computations with it are plain arrays.
    """

    references: Sequence[str]
    r: FloatArray

    def __getitem__(self, key: Any) -> Any:
        if not isinstance(key, str) or key in self.names:
            return super().__getitem__(key)
        if key in self.references:
            return self.r[self.references.index(key)]
        raise unknown_name("state or reference", key, (*self.names, *self.references))

    def __getattr__(self, name: str) -> Any:
        known = (*getattr(type(self), "names", ()), *getattr(type(self), "references", ()))
        raise AttributeError(f"unknown state or reference {name!r} of a law's argument; known: {', '.join(known)}")


@functools.cache
def state_type(names: tuple[str, ...], references: tuple[str, ...]) -> type[State]:
    """Return the state class of a model, with one property per name."""
    fields: dict[str, Any] = {name: property(functools.partial(_element, name)) for name in (*references, *names)}
    return type("State", (State,), {**fields, "names": names, "references": references})


def _element(name: str, state: State) -> Any:
    return state[name]
