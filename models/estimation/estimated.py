# SPDX-License-Identifier: Apache-2.0
"""Laws that compute with estimates: a Kalman filter of any system, built from its equations and noise."""

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
    """Return a system whose sampled law computes with state estimates in place of the state.

    Parameters
    ----------
    system : System
        With a sensor, each of whose measurements has noise of its own.
    law : str
        A sampled law, written as a function of the state.
    start : mapping of str to (mean, deviation)
        Of each state before the first sample, by name: expressions in the parameters, or numbers, which become
        parameters of the law, `STATE_est_0` and `STATE_dev_0`.
    noise : mapping of str to Expr, optional
        By states, a density of noise of their rates beside that of the system, in the unit of the state over s^(1/2);
        a number becomes the parameter `STATE_noise`.
    kind : {"extended", "sigma-point"}
        The filter: by exact derivatives at the estimate, or by points around it, for strongly bent equations.

    Returns
    -------
    System
        With the law's memory longer by the estimates `STATE_est` for the next sample, the factors of their covariance,
        the inputs of a sample as `INPUT_last`, and `est_nis`, the squared innovation over its variance; a run shows
        `est_nees`, the squared error over the covariance. A law without a delay of its own gets the parameter
        `est_delay`, which a run sets.

    Raises
    ------
    ModelError
        If the law is continuous, a measurement has no noise of its own, a command does not act at once, or a name is
        none of a state. A run with a delay of more than one sample is refused.
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
        raise ModelError(f"start = {dict(start)}: must have mean and deviation of {', '.join(missing)} too")
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
