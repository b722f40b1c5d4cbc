# SPDX-License-Identifier: Apache-2.0
"""Laws that use estimates from a Kalman filter, which is built from the equations and noise of any system."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

from ..arguments import expression, expressions, instance
from ..derivation import Expr
from ..quantities import ModelError, wrong
from ..system import System
from ..tables import check_names
from .cubature import CubatureFilter
from .extended import ExtendedFilter, Start

Kind = Literal["extended", "sigma-point"]
_KINDS = {"extended": ExtendedFilter, "sigma-point": CubatureFilter}


def estimated(
    system: System, law: str, start: Start, noise: Mapping[str, Expr | float] | None = None, kind: Kind = "extended"
) -> System:
    """Return a system whose sampled law uses estimates in place of the state.

    Parameters
    ----------
    system : System
        With a sensor whose measurements have independent noise.
    law : str
        A sampled law that is a function of the state.
    start : mapping of str to (mean, deviation)
        Mean and deviation of each state before the first sample, by name: expressions in the parameters, or numbers,
        which become the law's parameters `STATE_est_0` and `STATE_dev_0`.
    noise : mapping of str to Expr, optional
        Additional noise density of the rate of a state, by name, in the unit of the state over s^(1/2). A number
        becomes the parameter `STATE_noise`.
    kind : {"extended", "sigma-point"}
        Filter with exact derivatives at the estimate, or with points around it for strongly nonlinear equations.

    Returns
    -------
    System
        The law's memory also holds the predictions `STATE_est`, their factored covariance, the last inputs
        `INPUT_last`, and `est_nis`, the normalised innovation squared. A run reports `est_nees`, the normalised
        estimation error squared. A law without a delay gets the parameter `est_delay`, which a run sets.

    Raises
    ------
    ModelError
        If the law is continuous, a measurement has no independent noise, a command is delayed, or a name is not a
        state. A run refuses a delay of more than one sample.
    """
    instance("system", system, System, "a System")
    instance("law", law, str, "the name of a law")
    if not isinstance(kind, str) or kind not in _KINDS:
        raise wrong("kind", kind, " or ".join(map(repr, _KINDS)))
    names = [q.name for q in system.states]
    check_names([law], [one.name for one in system.controllers], "law")
    for what, given in (("start", start), ("noise", {} if noise is None else noise)):
        if not isinstance(given, Mapping) or not all(isinstance(name, str) for name in given):
            raise wrong(what, given, "a mapping by names of states")
        check_names(given, names, "state")
    for name, value in start.items():
        for entry in expressions(f"start[{name!r}]", value, 2):
            _finite(f"start[{name!r}]", entry)
    for name, density in (noise or {}).items():
        _finite(f"noise[{name!r}]", expression(f"noise[{name!r}]", density))
    if missing := [name for name in names if name not in start]:
        raise ModelError(f"start = {dict(start)}: must also have mean and deviation of {', '.join(missing)}")
    chosen = next(one for one in system.controllers if one.name == law)
    if not chosen.period or system.sensor is None:
        raise ModelError(f"{chosen.origin}: law {law!r}: estimates need a sampled law and a system with a sensor")
    for what, unsupported in (("commands every few samples", chosen.every), ("has inputs with delays", system.delays)):
        if unsupported:
            needed = "estimates need commands without delay, at each sample"
            raise ModelError(f"{chosen.origin}: law {law!r}: {what}: {needed}")
    return _KINDS[kind](system, chosen, start, noise or {}).system()


def _finite(name: str, value: Expr) -> None:
    if value.is_number and not (value.is_finite and value.is_real):
        raise wrong(name, value, "finite")
