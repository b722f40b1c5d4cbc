# SPDX-License-Identifier: Apache-2.0
"""Generated functions in a closed loop, by their names in native/step/calls.h."""

from __future__ import annotations

from collections.abc import Mapping

from mehvar.base.capabilities import Operation, refused_feature
from mehvar.base.errors import InputError, bad_value, either
from mehvar.base.manifest import Controller, Event, Function, Manifest
from mehvar.base.names import identifier

from .options import EXPLICIT, IMPLICIT, INTEGRATORS, METHODS, STIFF, STOCHASTIC, Integrator, Method

_AROUND = ("start", "to_coordinates", "from_coordinates")
"""Functions that are called before and after a loop, but not in it."""


def loop_calls(
    manifest: Manifest, controller: Controller, suffix: str, sampled: bool, method: Integrator = EXPLICIT
) -> dict[str, Function]:
    """Return the functions that a loop calls and that the model has.

    Parameters
    ----------
    manifest : Manifest
        Manifest of the model.
    controller : Controller
        The law; one in Python has no functions.
    suffix : str
        Suffix of the functions that only the chosen variant of the plant has.
    sampled : bool
        True for a sampled law.
    method : str
        Integration method; a linearly implicit one calls the Jacobian too.

    Raises
    ------
    InputError
        If a function is missing, or takes other arguments.
    """
    functions = {identifier(name): function for name, function in manifest.functions.items()}
    law, charted = identifier(controller.name), "to_coordinates" in functions
    generated = controller.name in manifest.controllers
    names = {"reference": "reference", "outputs": "outputs"}
    if manifest.limits:
        names["limits"] = "limits"
    if events_of(manifest, controller, sampled):
        names["guards" if sampled else "loop_guards"] = "guards" if sampled else f"{law}_guards"
    if any(event.resets for event in manifest.events):
        names["resets"] = "resets"
    if sampled:
        names |= {"rhs": f"rhs{suffix}"} | ({"law": law} if generated else {})
        names |= {name: name for name in ("actuate", "measure", "jump", "input_delays") if name in functions}
    else:
        names |= {"loop": f"{law}_loop{suffix}", "observe": f"{law}_observe"}
        names |= {name: name for name in ("to_coordinates", "from_coordinates") if charted}
    if manifest.algebraic:
        names["mass"] = "mass_diagonal"
    names |= {"start": f"{law}_start"} if controller.memory and generated else {}
    if manifest.wiener:
        names["diffuse"] = "diffuse"
    if method in IMPLICIT:
        names["rhs_jac" if sampled else "loop_jac"] = jacobian_name(manifest, controller, suffix, sampled)
    if "project" in functions and not (sampled and charted):
        names["project"] = "project"
    for name in names.values():
        if name not in functions:
            raise InputError(f"the generated folder lacks the function {name}; generate the model again")
    calls = {call: functions[name] for call, name in names.items()}
    # the manifest checks the signature of the plain slope only; C calls all slopes by one type
    for call, plain in (("rhs", "rhs"), ("rhs_jac", "rhs"), ("loop", f"{law}_loop"), ("loop_jac", f"{law}_loop")):
        if call in calls and plain in functions:
            present, expected = _arguments(calls[call]), _arguments(functions[plain])
            if present != expected:
                raise InputError(f"{names[call]} takes {present}, must be {expected}; generate the model again")
    return calls


def _arguments(function: Function) -> str:
    return " ".join(array.name for array in function.arguments)


def check_loop(
    manifest: Manifest, law: Controller, method: Method, hold: float | None, sampled: bool, origin: str
) -> None:
    """Refuse a method or sampling that does not support a feature of model or law.

    Parameters
    ----------
    manifest, law
        The model and its law.
    method : str
        Integration method.
    hold : float or None
        The given hold time, s.
    sampled : bool
        True for a sampled law.
    origin : str
        Origin of the options in error messages.
    """
    if lacking := refused_feature(manifest, place_of(method)):
        suitable = either(name for name in METHODS if not refused_feature(manifest, place_of(name)))
        raise bad_value("method", method, f"{suitable}: {manifest.model} has {lacking}", f"{origin}, or the default")
    if method in STOCHASTIC and not manifest.wiener:
        raise bad_value("method", method, f"another one: {manifest.model} has no process noise", origin)
    if not sampled and (lacking := refused_feature(manifest, Operation.CONTINUOUS)):
        raise bad_value("hold", None, f"given, or a sampled law: {manifest.model} has {lacking}", origin)
    if hold is not None and (lacking := refused_feature(manifest, Operation.HELD, law)):
        raise bad_value("hold", hold, f"left out: {manifest.model} has {lacking}", origin)


def place_of(method: Method) -> Operation:
    """Return a method's column in the table of capabilities."""
    return (
        Operation.IMPLICIT
        if method in IMPLICIT
        else Operation.STOCHASTIC
        if method in STOCHASTIC
        else Operation.EXPLICIT
    )


def events_of(manifest: Manifest, controller: Controller, sampled: bool) -> tuple[Event, ...]:
    """Return the events of a loop: the system's and, for a continuous law, its surfaces."""
    return manifest.events if sampled else (*manifest.events, *controller.events)


def jacobian_name(
    manifest: Manifest, controller: Controller, suffix: str, sampled: bool, method: Method = STIFF
) -> str:
    """Return the name of a loop's Jacobian for linearly implicit methods.

    Raises
    ------
    InputError
        If the model has none; only its default variant has one.
    """
    name = f"jac_x{suffix}" if sampled else f"{identifier(controller.name)}_loop_jac{suffix}"
    if name not in map(identifier, manifest.functions):
        explicit = either(name for name in INTEGRATORS if name not in (*IMPLICIT, *STOCHASTIC))
        raise bad_value("method", method, f"{explicit}: {manifest.model} has no Jacobian {name}")
    return name


def model_fields(calls: Mapping[str, Function], manifest: Manifest, controller: Controller) -> dict[str, Function]:
    """Return the functions of a loop by address field of mv_model, native/single/single.h."""
    renamed = {"law": "law_memory"} if controller.memory else {}
    if "actuate" in manifest.functions:
        renamed["observe"] = "observe_command"
    if manifest.references:
        renamed["loop_jac"] = "loop_jac_r"
    if manifest.projects_by_parameters:
        renamed["project"] = "project_p"
    return {renamed.get(call, call): function for call, function in calls.items() if call not in _AROUND}
