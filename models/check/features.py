# SPDX-License-Identifier: Apache-2.0
"""Check that every declared feature has an effect and is compatible with the others."""

from __future__ import annotations

import itertools
import string
from collections.abc import Iterable, Iterator, Sequence

import sympy as sp

from mehvar.base import capabilities
from mehvar.base.capabilities import Feature, Names
from mehvar.base.errors import either, suggestion
from mehvar.base.intervals import Interval
from mehvar.base.manifest import SHAPE_COLORS, SHAPE_KINDS
from mehvar.base.units import dimension

from ..forms import algebraic_rows, has_rates
from ..quantities import Group, Located, ModelError, Parameter
from ..system import Condition, Controller, System, Variant
from ..tables import check_names
from .dimensions import placed
from .events import check_events
from .names import check_distinct

_OF_SAMPLES = ("delay", "every", "applied", "update", "tolerates_loss")
"""Fields that only a sampled law may declare."""
_OF_MEMORY = ("applied", "start", "update", "rates")
"""Fields that only a law with memory may declare."""


def check_features(system: System) -> None:
    """Refuse declarations without effect, and impossible combinations."""
    if not len(system.states):
        raise ModelError(f"{system.origin}: states = (): a system must have at least one state")
    for law in system.controllers:
        _check_times(system, law)
        _check_law(law)
    check_events(system)
    _check_noise(system)
    _check_delays(system)
    _check_choices(system)
    if len(system.residual) != len(system.rates):
        raise ModelError(
            f"{system.origin}: residual has {len(system.residual)} entries for {len(system.rates)} rates: there must "
            "be one for each"
        )
    _check_mass(system)
    _check_beside(system)
    _check_geometry(system)
    _check_messages(system)


def _check_mass(system: System) -> None:
    """Refuse a mass matrix of the wrong shape, and one that determines no rate."""
    if system.mass is None:
        return
    n = len(system.states)
    if system.mass.shape != (n, n):
        raise ModelError(
            f"{system.origin}: mass has the shape {system.mass.shape}: must have a row and a column for each of the "
            f"{n} states"
        )
    if len(algebraic_rows(system)) == n:
        raise ModelError(f"{system.origin}: mass is zero: at least one state must have a rate")


def _check_beside(system: System) -> None:
    """Refuse features that exclude each other."""
    present = {feature: (part.origin, feature.listed(names)) for feature, part, names in _features(system) if names}
    for one, other, reason in capabilities.EXCLUSIONS:
        if one in present and other in present:
            origin, words = present[one]
            raise ModelError(f"{origin}: {words} cannot be combined with {other.name}: {reason}")


def _features(system: System) -> Iterator[tuple[Feature, Located, Names]]:
    """Yield each feature with the part of the system that declares it and its names in messages."""
    laws = system.controllers
    events = [*system.events, *(event for law in laws for event in law.events)]
    continuous, integrated = [law.name for law in laws if not law.period], [law for law in laws if law.rates]
    resets = [event for event in events if event.reset]
    sensor, actuator, diffusion = system.sensor or system, system.actuator or system, system.diffusion or system
    yield capabilities.MASS, system, system.mass is not None
    yield capabilities.ALGEBRAIC, system, [system.states.quantities[k].name for k in algebraic_rows(system)]
    yield capabilities.DERIVED_RATES, system, bool(system.residual or system.rates) and not has_rates(system)
    yield capabilities.EVENTS, events[0] if events else system, [event.name for event in events]
    yield capabilities.RESETS, resets[0] if resets else system, [event.name for event in resets]
    yield capabilities.PROCESS_NOISE, diffusion, system.diffusion is not None
    yield capabilities.CHART, system.coordinates or system, system.coordinates is not None
    yield capabilities.ACTUATOR, actuator, continuous if system.actuator is not None else False
    yield capabilities.MEASURED, sensor, continuous if system.seen is not system.states else False
    yield capabilities.CHOICES, system, [choice.name for choice in system.choices]
    yield capabilities.INTEGRATED, integrated[0] if integrated else system, [law.name for law in integrated]


def _check_geometry(system: System) -> None:
    """Refuse shapes that cannot be drawn."""
    for shape in system.geometry:
        where = f"{shape.origin}: shape {shape.name!r}"
        if shape.color not in SHAPE_COLORS:
            raise ModelError(f"{where}: color = {shape.color!r}: must be {either(SHAPE_COLORS)}")
        least, most = SHAPE_KINDS[shape.kind]
        if not least <= len(shape.points) <= most:
            number = f"{least}" if least == most else f"{least} or more"
            raise ModelError(f"{where} has {len(shape.points)} points: a {shape.kind} must have {number}")
    check_distinct([shape.name for shape in system.geometry], f"{system.origin}: shape")


def _check_law(law: Controller) -> None:
    """Refuse fields that need a period or memory if the law has none, since they would be ignored."""
    for names, missing in ((_OF_SAMPLES, "period"), (_OF_MEMORY, "memory")):
        for name in names:
            if name == "applied" and law.every:
                continue  # a law that commands at some samples has memory
            value = getattr(law, name)
            if (len(value) if isinstance(value, Group | tuple) else value) and not getattr(law, missing):
                kind = "continuous in time (it has no period)" if missing == "period" else "without memory"
                raise ModelError(f"{law.origin}: {name} of law {law.name!r} would be ignored: the law is {kind}")
    if law.period and law.rates:
        raise ModelError(
            f"{law.origin}: rates of law {law.name!r} would be ignored: the law is sampled; give update instead"
        )


def _check_times(system: System, law: Controller) -> None:
    """Refuse a law whose period, delay or sample count is no parameter, or has another unit or values."""
    for what, name, group, unit, least, example in (
        ("period", law.period, system.parameters, "s", "above zero", "(0, inf)"),
        ("delay", law.delay, law.parameters, "1", "", ""),
        ("every", law.every, law.parameters, "1", "at least 1", "[1, inf)"),
    ):
        where, own = f"{law.origin}: {what} = {name!r} of law {law.name!r}", {q.name: q for q in group}
        if not name:
            continue
        if name not in own:
            raise ModelError(f"{where} is not a parameter of group {group.name!r}{suggestion(name, own)}")
        q = own[name]
        with placed(where):
            if dimension(q.unit) != dimension(unit):
                raise ModelError(f"{where} has the unit {q.unit}: must be {unit}")
        if example and isinstance(q, Parameter) and q.bounds.common(Interval.parse(example)) != q.bounds:
            raise ModelError(f"{where} has the bounds {q.bounds}: all values must be {least}, as in {example}")


def _check_noise(system: System) -> None:
    """Refuse process noise that is zero, and random steps that never occur."""
    diffusion, step = system.diffusion, system.random_step
    if diffusion:
        for q in diffusion.wiener:
            if q.unit != "s^(1/2)":
                raise ModelError(
                    f"{diffusion.origin}: Wiener process {q.name!r} has the unit {q.unit}: must be s^(1/2)"
                )
        for k, row in enumerate(diffusion.change):
            if not _linear(row, diffusion.wiener.symbols):
                raise ModelError(
                    f"{diffusion.origin}: row {k + 1} of the diffusion's change, {row}, must be linear in "
                    f"{', '.join(q.name for q in diffusion.wiener)}, as in p.sigma * dW"
                )
    if step and not any(law.period for law in system.controllers):
        raise ModelError(
            f"{step.origin}: random_step would be ignored: it acts at the samples of a law, and no law has a period"
        )


def check_sensor(system: System) -> None:
    """Refuse a continuous law that reads states if the system's sensor does not measure the states."""
    sensor, continuous = system.sensor, [law.name for law in system.controllers if not law.period]
    if sensor is None or system.seen is not system.states or not continuous:
        return
    quiet = dict.fromkeys(sensor.noise.symbols, 0)
    for q, row in zip(system.states, sensor.measured, strict=True):
        if sp.expand(sp.sympify(row).subs(quiet) - q.symbol) != 0:
            raise ModelError(
                f"{sensor.origin}: the sensor measures {q.name} as {row}, but the continuous law "
                f"{continuous[0]!r} would receive the state itself: give the measurements names (seen)"
            )


def _check_delays(system: System) -> None:
    """Refuse delays of anything but inputs, and delays that are not a whole number of samples."""
    parameters = {q.name: q for q in system.parameters}
    check_names(system.delays, [q.name for q in system.inputs], f"{system.origin}: delays: input")
    check_names(system.delays.values(), list(parameters), f"{system.origin}: delays: parameter")
    for name in system.delays.values():
        q = parameters[name]
        if isinstance(q, Parameter) and not (q.bounds.lower >= 0 and q.unit == "1"):
            raise ModelError(
                f"{system.origin}: delays: parameter {name!r} is in {q.unit} with the bounds {q.bounds}: must be a "
                "number of samples, zero or above, as in [0, 100]"
            )
    if system.delays and not any(law.period for law in system.controllers):
        raise ModelError(
            f"{system.origin}: delays would be ignored: they are counted in samples of a law with a period"
        )


def _linear(row: sp.Expr, symbols: Sequence[sp.Symbol]) -> bool:
    slopes = [row.diff(symbol) for symbol in symbols]
    rest = sp.expand(row - sum(slope * symbol for slope, symbol in zip(slopes, symbols, strict=True)))
    return rest == 0 and not any(slope.free_symbols.intersection(symbols) for slope in slopes)


def _check_choices(system: System) -> None:
    """Refuse choices without two values, and variants other than all combinations but the first."""
    options = [choice.values for choice in system.choices]
    for choice in system.choices:
        if len(choice.values) < 2 or len(set(choice.values)) < len(choice.values):
            raise ModelError(
                f"{system.origin}: choice {choice.name!r} has the values {choice.values}: must be two or more "
                "different ones"
            )
    check_distinct([choice.name for choice in system.choices], f"{system.origin}: choice")
    wanted = [values for values in itertools.product(*options) if values != tuple(v[0] for v in options)]
    present = [variant.values for variant in system.variants]
    for variant in system.variants:
        _check_variant(system, variant, wanted)
    check_distinct(present, f"{system.origin}: variant")
    missing = [values for values in wanted if values not in present]
    if missing:
        raise ModelError(
            f"{system.origin}: 'variants' has no entry for {missing[0]}: give one entry for each "
            "combination of choices except the first"
        )


def _check_variant(system: System, variant: Variant, wanted: Sequence[tuple[str, ...]]) -> None:
    if variant.values not in wanted:
        allowed = ", ".join(map(str, wanted)) or "none, for the system has no choices"
        raise ModelError(f"{variant.origin}: a variant has values = {variant.values}; allowed: {allowed}")
    continuous = [law.name for law in system.controllers if not law.period]
    check_names(variant.loops, continuous, f"{variant.origin}: loops of variant {variant.values}: continuous law")


def _check_messages(system: System) -> None:
    """Refuse messages whose placeholders and values do not match."""
    p, s = ([q.name for q in group] for group in (system.parameters, system.scenario_parameters))
    _check_conditions("limits", system.limits, p, False)
    _check_conditions("constraints", system.constraints, [*p, *s], False)
    for law in system.controllers:
        names = [*p, *s, *(q.name for q in law.parameters)]
        _check_conditions(f"constraints of law {law.name!r}", law.constraints, names, False)
        _check_conditions(f"warnings of law {law.name!r}", law.warnings, names, True)


def _check_conditions(what: str, conditions: Iterable[Condition], names: Sequence[str], shows: bool) -> None:
    """Refuse messages with unknown places, and values to show without a place."""
    for condition in conditions:
        where = f"{condition.origin}: message of {what}"
        if condition.shown and not shows:
            raise ModelError(f"{where}: shown would be ignored: only warnings of a law print values")
        values = [str(k) for k in range(len(condition.shown))]
        try:
            places = [place for _, place, _, _ in string.Formatter().parse(condition.message) if place is not None]
            condition.message.format(*(0.0 for _ in values), **dict.fromkeys(names, 0.0))
        except (ValueError, KeyError, IndexError, AttributeError, TypeError) as error:
            allowed = ", ".join((*values, *names)) or "none"
            raise ModelError(
                f"{where} {condition.message!r} cannot be filled in ({error}); places: {allowed}"
            ) from None
        unshown = [value for value in values if value not in places]
        if unshown:
            raise ModelError(f"{where} {condition.message!r} lacks a place for the value {{{unshown[0]}}}")
