# SPDX-License-Identifier: Apache-2.0
"""Generated functions on JAX arrays, for `jit`, `vmap` and `grad`."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import nullcontext
from types import SimpleNamespace
from typing import Any

from mehvar.base.manifest import Manifest

from .replacement import Translation, library, with_globals


def jax_functions(manifest: Manifest) -> Translation:
    """Return all generated functions on JAX arrays; `jax_enable_x64` decides their precision.

    Raises
    ------
    InputError
        If JAX is not installed.
    """
    numpy = library("jax.numpy", "jax", "to_jax")
    erf = library("jax.scipy.special", "jax", "to_jax").erf
    quiet = SimpleNamespace(**vars(numpy), errstate=lambda **_: nullcontext())  # compiled arithmetic does not warn

    def vector(*elements: Any) -> Any:
        return numpy.stack(numpy.broadcast_arrays(*elements), axis=-1) if elements else numpy.empty(0)

    def translate(_: str, generated: Callable[..., Any]) -> Any:
        arrays = lambda *values: tuple(numpy.asarray(value, dtype=float_of(numpy)) for value in values)  # noqa: E731
        return with_globals(generated, np=quiet, _arrays=arrays, _vector=vector, _erf=erf)

    return Translation(manifest, translate)


def float_of(numpy: Any) -> Any:
    """Return the type of Python floats in JAX, which is double only with `jax_enable_x64`."""
    return numpy.result_type(float)
