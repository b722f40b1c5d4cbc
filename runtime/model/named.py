# SPDX-License-Identifier: Apache-2.0
"""Vectors with named elements: the results of `Model.parameters` and `Model.state`."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from mehvar.base.errors import unknown_name


class NamedVector(np.ndarray[Any, np.dtype[np.float64]]):
    """A vector whose elements can be read and set by name, as in `p.mass` or `p["mass"]`.

    An element with the name of an array attribute, such as `T`, needs brackets. Computation, slicing and pickling
    return plain arrays.
    """

    __slots__ = ()  # writing to a misspelt name is an error, too
    names: Sequence[str] = ()

    if TYPE_CHECKING:  # the properties of the names, which a checker cannot know

        def __getattr__(self, name: str) -> Any: ...

        def __setattr__(self, name: str, value: Any) -> None: ...

    def __getitem__(self, key: Any) -> Any:
        return self.view(np.ndarray)[self._place(key)]

    def __setitem__(self, key: Any, value: Any) -> None:
        self.view(np.ndarray)[self._place(key)] = value

    def __repr__(self) -> str:
        if self.shape != (len(self.names),):
            return repr(self.view(np.ndarray))
        return f"NamedVector({', '.join(f'{name}={value:g}' for name, value in zip(self.names, self, strict=True))})"

    def __array_wrap__(self, array: Any, context: Any = None, return_scalar: bool = False) -> Any:
        plain = np.asarray(array)
        return plain[()] if return_scalar or plain.ndim == 0 else plain

    def __reduce__(self) -> Any:
        return self.view(np.ndarray).__reduce__()

    def _place(self, key: Any) -> Any:
        if not isinstance(key, str):
            return key
        if key not in self.names:
            raise unknown_name("name of this vector", key, self.names)
        return self.names.index(key)

    def _ipython_key_completions_(self) -> list[str]:
        return list(self.names)


def named(values: ArrayLike, names: tuple[str, ...]) -> NamedVector:
    """Return a copy of numbers as a vector whose elements have names."""
    return np.array(values, dtype=np.float64).view(_vector_type(names))


@functools.cache
def _vector_type(names: tuple[str, ...]) -> type[NamedVector]:
    """Return the class of vectors with these names as properties, so that editors complete them."""
    free = [name for name in names if not hasattr(NamedVector, name)]
    fields: dict[str, Any] = {name: property(_getter(name), _setter(name)) for name in free}
    return type("NamedVector", (NamedVector,), {**fields, "names": names, "__slots__": ()})


def _getter(name: str) -> Any:
    return lambda vector: vector[name]


def _setter(name: str) -> Any:
    return lambda vector, value: vector.__setitem__(name, value)
