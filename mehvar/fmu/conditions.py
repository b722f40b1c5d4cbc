# SPDX-License-Identifier: Apache-2.0
"""C code that refuses invalid start values of an FMU: bounds of parameters and other conditions."""

from __future__ import annotations

import json
import math
import re
import string
from collections.abc import Sequence

import numpy as np

from mehvar.base.manifest import Parameter
from mehvar.base.names import identifier

from .variables import Subject

_TEXT = 1024
"""Largest size of a message in bytes; the rest is cut off."""


def refusals(subject: Subject) -> list[str]:
    """Return the text of a C function that refuses invalid values v and writes the reason.

    Conditions with scenario parameters, which an FMU lacks, apply only to its start.
    """
    manifest, law = subject.model.manifest, subject.law
    bounds = [
        line
        for group, parameters in (("P", manifest.parameters), ("C", law.parameters if law else ()))
        for place, parameter in enumerate(parameters, subject.first(group))
        for line in _bound(subject, place, parameter)
    ]
    lines = _conditions(subject, "constraints", manifest.constraints, "ps")
    if law is not None:
        lines += _conditions(subject, f"{identifier(law.name)}_constraints", law.constraints, "pcs")
    return [
        f"#define FMU_TEXT {_TEXT}",
        "static int fmu_refuses(const double *v, int as_scenario, char *text)",
        "{",
        f"    static const double s[] = {{{', '.join(map(repr, [*subject.s.tolist(), 0.0]))}}};",
        "    const double *const p = v + FMU_V_P, *const c = v + FMU_V_C;",
        "    (void)s, (void)p, (void)c, (void)as_scenario, (void)text;",
        *bounds,
        *lines,
        "    return 0;",
        "}",
    ]


def _bound(subject: Subject, place: int, parameter: Parameter) -> list[str]:
    """Return the C line that refuses a parameter outside its bounds; no line for one without bounds."""
    inside = []
    if math.isfinite(parameter.lower):
        inside.append(f"v[{place}] {'>' if parameter.lower_open else '>='} {float(parameter.lower)!r}")
    if math.isfinite(parameter.upper):
        inside.append(f"v[{place}] {'<' if parameter.upper_open else '<='} {float(parameter.upper)!r}")
    if not inside:
        return []
    name = subject.variables[place].name
    text = f"{_literal(name)} = %g: must be in {_literal(parameter.allowed)}"
    return [f"    if (!({' && '.join(inside)})) return {_say(text, [f'v[{place}]'])};"]


def _conditions(subject: Subject, name: str, messages: Sequence[str], groups: str) -> list[str]:
    """Return C code that refuses margins that are not positive; those of scenario parameters only `as_scenario`."""
    if not messages:
        return []
    function = subject.model.functions[name]
    vectors = {group: np.array([v.start for v in subject.groups[group.upper()]]) for group in groups if group != "s"}
    free = np.isfinite(function(*vectors.values(), np.full(len(subject.s), math.nan)))
    lines = [
        "    {",
        f"        double margin[{len(messages)}];",
        f"        {identifier(subject.model.name)}_{identifier(name)}({', '.join(groups)}, margin);",
    ]
    for k, message in enumerate(messages):
        when = "" if free[k] else "as_scenario && "
        lines.append(f"        if ({when}!(margin[{k}] > 0)) return {_message(subject, message)};")
    return [*lines, "    }"]


def _message(subject: Subject, message: str) -> str:
    """Return the C expression that writes a manifest's message with the current values."""
    values = {q.name: f"s[{k}]" for k, q in enumerate(subject.model.manifest.scenario_parameters)}
    for group, parameters in (
        ("C", subject.law.parameters if subject.law else ()),
        ("P", subject.model.manifest.parameters),
    ):
        values |= {q.name: f"v[{place}]" for place, q in enumerate(parameters, subject.first(group))}
    text, places = "", []
    for literal, field, spec, _ in string.Formatter().parse(message):
        text += _literal(literal)
        if field is None:
            continue
        if field not in values:
            return _say(_literal(message), [])
        text += f"%{spec if re.fullmatch(r'[.]?[0-9]*[efg]', spec or '') else 'g'}"
        places.append(values[field])
    return _say(text, places)


def _say(text: str, values: Sequence[str]) -> str:
    return f"snprintf({', '.join(['text', 'FMU_TEXT', json.dumps(text, ensure_ascii=False), *values])}), 1"


def _literal(text: str) -> str:
    return text.replace("%", "%%")
