# SPDX-License-Identifier: Apache-2.0
"""Check that a run uses its given parameters."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from functools import partial

from mehvar.base.errors import bad_value, run_checks
from mehvar.base.manifest import OPEN_LOOP, Controller, Manifest
from mehvar.base.names import identifier

from ..model.parameters import all_parameters
from .calls import loop_calls

_INITIAL = "initial"


def check_read(
    manifest: Manifest,
    law: Controller,
    suffix: str,
    sampled: bool,
    values: Mapping[str, object],
    states: Collection[str],
    origin: str,
) -> None:
    """Refuse a parameter without effect, which no function reads or whose dependent values are given.

    Parameters
    ----------
    manifest, law
        The model and its law.
    suffix : str
        Suffix of the functions that only the chosen variant of the plant has.
    sampled : bool
        True for a sampled law.
    values : mapping of str to object
        Given parameters, as numbers or distributions.
    states : collection of str
        States with a given start.
    origin : str
        Origin of the values in error messages.

    Raises
    ------
    InputError
        With a line for each parameter; it names the readers.
    """
    reading = _Reading(manifest, law, _functions(manifest, law, suffix, sampled), {*values, *states})

    def check(name: str) -> None:
        if not reading.acts(name):
            raise bad_value(name, values[name], f"left out: {reading.reason(name)}", origin)

    run_checks(*(partial(check, name) for name in values))


def _functions(manifest: Manifest, law: Controller, suffix: str, sampled: bool) -> set[str]:
    """Return the functions whose results a run uses or shows."""
    generated, name = law.name in manifest.controllers, identifier(law.name)
    calls = {identifier(f.name) for f in loop_calls(manifest, law, suffix, sampled or not generated).values()}
    if generated or law.name == OPEN_LOOP:
        calls.discard("reference")  # its users are readers themselves, but a law in Python may use it
    if not sampled:
        calls.discard("measure")
    return calls | {f"{name}_outputs"}


class _Reading:
    """Parameters that affect a run's functions if some elements are given."""

    def __init__(self, manifest: Manifest, law: Controller, functions: set[str], given: set[str]) -> None:
        self._law, self._functions, self._given = law, functions, given
        self._readers: dict[str, set[str]] = {}
        for q in all_parameters(manifest, law):
            self._readers.setdefault(q.name, set()).update(q.readers)

    def acts(self, name: str) -> bool:
        """Return True if a parameter has an effect."""
        decided = self._decided(name)
        return (
            name in (self._law.period, self._law.delay)
            or not self._functions.isdisjoint(self._readers[name])
            or any(element not in self._given and (start or self.acts(element)) for element, start in decided.items())
        )

    def reason(self, name: str) -> str:
        """Return the reason why a parameter has no effect."""
        elements = [element for element in self._decided(name) if element in self._given]
        if elements:
            return f"here it only determines {', '.join(elements)}, which is given too: give one of them"
        others = sorted(reader for reader in self._readers[name] if "." not in reader)
        return f"no function of a run under {self._law.name} reads it{', only ' + ', '.join(others) if others else ''}"

    def _decided(self, name: str) -> dict[str, bool]:
        """Return the states and parameters that depend on a parameter; True marks initial states."""
        places = {_INITIAL: True, f"{identifier(self._law.name)}_defaults": False}
        pairs = (reader.split(".") for reader in self._readers[name] if "." in reader)
        return {element: places[function] for function, element in pairs if function in places}
