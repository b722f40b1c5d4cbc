# SPDX-License-Identifier: Apache-2.0
"""Law of a run: one of the model, a Python function, or inputs over time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from mehvar.base.errors import bad_value
from mehvar.base.manifest import Controller, Manifest

from ..options import OPTIONS
from .inputs import open_loop
from .law import LawFunction, PythonLaw, python_law

if TYPE_CHECKING:
    import xarray


def law_of(
    manifest: Manifest,
    controller: str | LawFunction | PythonLaw | None,
    inputs: Mapping[str, object] | xarray.Dataset | None,
    interpolation: str | None,
    period: float | None,
    memory: ArrayLike | None,
    end: float,
    origin: str,
) -> tuple[Controller, PythonLaw | None]:
    """Return the description of a run's law, and the law itself if it is in Python.

    Parameters
    ----------
    manifest : Manifest
        Manifest of the model.
    controller, inputs, interpolation, period, memory
        As for `simulate`.
    end : float
        End of the run, s.
    origin : str
        Origin of the arguments in error messages.

    Raises
    ------
    InputError
        For an invalid law, or an argument that this kind of law does not take.
    """
    given = {"inputs": inputs, "interpolation": interpolation, "period": period, "memory": memory}
    if period is not None:
        period = OPTIONS["hold"].check(period, f"{origin}, period")
    if controller is None:
        if inputs is None:
            raise bad_value(
                "controller", controller, "a law, unless inputs are given; inputs={} sets all inputs to zero", origin
            )
        _refuse(given, ("memory",), "left out without a law", origin)
        own = open_loop(inputs, manifest, period, interpolation, end, origin)
        return own.controller, own
    if isinstance(controller, PythonLaw):
        return controller.controller, controller
    if callable(controller):
        _refuse(given, ("inputs", "interpolation"), "left out with a law, which gives the inputs", origin)
        own = python_law(controller, manifest, period, memory, origin)
        return own.controller, own
    if not isinstance(controller, str):
        raise bad_value(
            "controller", controller, "the name of a law, a function law(t, x), or None with inputs", origin
        )
    _refuse(given, ("inputs", "interpolation"), "left out with a law, which gives the inputs", origin)
    _refuse(given, ("memory",), "left out with a law of the model, which has its own", origin)
    _refuse(given, ("period",), "left out with a law of the model: hold says how often that is sampled", origin)
    return manifest.controller(controller), None


def _refuse(given: Mapping[str, object], names: tuple[str, ...], allowed: str, origin: str) -> None:
    for name in names:
        if given[name] is not None:
            raise bad_value(name, given[name], allowed, origin)
