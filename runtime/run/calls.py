# SPDX-License-Identifier: Apache-2.0
"""Which generated functions a closed loop calls, by the names that native/step/calls.h has for them."""

from __future__ import annotations

from mehvar.errors import InputError
from mehvar.manifest import Controller, Function, Manifest
from mehvar.names import identifier

_ARGUMENTS = {
    "reference": "t p s",
    "rhs": "x u p",
    "loop": "q r p c",
    "observe": "q r p c",
    "outputs": "x u r p",
    "limits": "x u p",
    "law": "x r p c",
    "law with memory": "x r v z p c",
    "actuate": "x u_cmd p",
    "measure": "x e p",
    "project": "q",
    "start": "x r p c",
    "to_coordinates": "x",
    "from_coordinates": "q",
}


def loop_calls(manifest: Manifest, controller: Controller, suffix: str, sampled: bool) -> dict[str, Function]:
    """Return the functions behind the calls of a loop; a call that the model has no function for is absent.

    Parameters
    ----------
    manifest : Manifest
        Of the model.
    controller : Controller
        The law; one in Python has no functions.
    suffix : str
        Of the functions that the chosen variant of the plant has of its own.
    sampled : bool
        Whether the law is sampled.

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
    if sampled:
        names |= {"rhs": f"rhs{suffix}"} | ({"law": law} if generated else {})
        names |= {name: name for name in ("actuate", "measure") if name in functions}
        names |= {"start": f"{law}_start"} if controller.memory and generated else {}
    else:
        names |= {"loop": f"{law}_loop{suffix}", "observe": f"{law}_observe"}
        names |= {name: name for name in ("to_coordinates", "from_coordinates") if charted}
    if "project" in functions and not (sampled and charted):
        names["project"] = "project"
    return {call: _function(functions, name, _arguments(call, controller)) for call, name in names.items()}


def _arguments(call: str, controller: Controller) -> list[str]:
    return _ARGUMENTS["law with memory" if call == "law" and controller.memory else call].split()


def _function(functions: dict[str, Function], name: str, arguments: list[str]) -> Function:
    function = functions.get(name)
    if function is None or [a.name for a in function.arguments] != arguments:
        signature = f"{name}({', '.join(arguments)})"
        raise InputError(f"the generated folder lacks the function {signature}; generate the model again")
    return function
