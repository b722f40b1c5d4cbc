# SPDX-License-Identifier: Apache-2.0
"""Whether a run reads the parameters that somebody gives it."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from functools import partial

from mehvar.errors import bad_value, together
from mehvar.manifest import OPEN_LOOP, Controller, Manifest
from mehvar.names import identifier

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
    """Refuse a parameter that changes nothing: what would read it does not run, or somebody gives what it decides.

    Parameters
    ----------
    manifest, law
        What is run.
    suffix : str
        Of the functions that the chosen variant of the plant has of its own.
    sampled : bool
        Whether the law is sampled.
    values : mapping of str to object
        Parameters that somebody gives, be it as a number or as a distribution.
    states : collection of str
        States whose start is given.
    origin : str
        How error messages call the values.

    Raises
    ------
    InputError
        With a line for each; it names what would read the parameter.
    """
    reading = _Reading(manifest, law, _functions(manifest, law, suffix, sampled), {*values, *states})

    def check(name: str) -> None:
        if not reading.acts(name):
            raise bad_value(name, values[name], f"left out: {reading.reason(name)}", origin)

    together(*(partial(check, name) for name in values))


def _functions(manifest: Manifest, law: Controller, suffix: str, sampled: bool) -> set[str]:
    """Return the functions of a run whose results it shows or goes by."""
    generated, name = law.name in manifest.controllers, identifier(law.name)
    calls = {identifier(f.name) for f in loop_calls(manifest, law, suffix, sampled or not generated).values()}
    if generated or law.name == OPEN_LOOP:
        calls.discard("reference")  # what takes it into account is a reader itself; a law in Python may look at it
    if not sampled:
        calls.discard("measure")
    return calls | {f"{name}_outputs"}


class _Reading:
    """Which parameters reach the functions of a run, where some elements are given instead of computed."""

    def __init__(self, manifest: Manifest, law: Controller, functions: set[str], given: set[str]) -> None:
        self._law, self._functions, self._given = law, functions, given
        self._readers: dict[str, set[str]] = {}
        for q in (*manifest.parameters, *law.parameters, *manifest.scenario_parameters):
            self._readers.setdefault(q.name, set()).update(q.readers)

    def acts(self, name: str) -> bool:
        """Tell whether a parameter has an effect."""
        decided = self._decided(name)
        return (
            name in (self._law.period, self._law.delay)
            or not self._functions.isdisjoint(self._readers[name])
            or any(element not in self._given and (start or self.acts(element)) for element, start in decided.items())
        )

    def reason(self, name: str) -> str:
        """Say why a parameter has no effect."""
        elements = [element for element in self._decided(name) if element in self._given]
        if elements:
            return f"it decides nothing here but {', '.join(elements)}, which is given too"
        others = sorted(reader for reader in self._readers[name] if "." not in reader)
        return f"nothing in a run under {self._law.name} reads it{', only ' + ', '.join(others) if others else ''}"

    def _decided(self, name: str) -> dict[str, bool]:
        """Return the states and parameters that follow from a parameter, and whether it is a state's start."""
        places = {_INITIAL: True, f"{identifier(self._law.name)}_defaults": False}
        pairs = (reader.split(".") for reader in self._readers[name] if "." in reader)
        return {element: places[function] for function, element in pairs if function in places}
