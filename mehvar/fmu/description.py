# SPDX-License-Identifier: Apache-2.0
"""modelDescription.xml of FMI 2.0 and 3.0."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from mehvar.base.units import dimension
from mehvar.base.versions import installed

from .sources import UNITS
from .variables import Subject, Variable

Version = Literal["2.0", "3.0"]
Interface = Literal["me", "cs"]
_DEGREE = math.pi / 180


def description(subject: Subject, version: Version, interface: Interface, name: str, token: str) -> bytes:
    """Return the text of modelDescription.xml.

    Parameters
    ----------
    subject : Subject
        Model and law.
    version, interface : str
        Version of the standard, "2.0" or "3.0"; "me" for model exchange or "cs" for co-simulation.
    name : str
        Identifier of the FMU and name of its binary.
    token : str
        Token that the sources contain too.
    """
    manifest, two = subject.model.manifest, version == "2.0"
    about = {
        "fmiVersion": version,
        "modelName": name,
        "guid" if two else "instantiationToken": token,
        "description": manifest.title + (f": {subject.law.title}" if subject.law else ""),
        "generationTool": f"mehvar {installed('mehvar').get('mehvar', '')}".strip(),
        "variableNamingConvention": "structured",
    }
    if two:
        indicators = subject.groups["M"] + subject.groups["G"] if interface == "me" else ()
        about["numberOfEventIndicators"] = str(len(indicators))
    root = Element("fmiModelDescription", about)
    _interface(root, subject, two, interface, name)
    _units(root, subject)
    if two:
        SubElement(SubElement(root, "LogCategories"), "Category", {"name": "logStatusError"})
    run = {"startTime": "0", "stopTime": repr(subject.duration)}
    if interface == "cs":
        run["stepSize"] = repr(subject.period or subject.step)
    SubElement(root, "DefaultExperiment", run)
    _variables(root, subject, two)
    _structure(root, subject, two, interface)
    indent(root)
    return b'<?xml version="1.0" encoding="UTF-8"?>\n' + tostring(root) + b"\n"


def _interface(root: Element, subject: Subject, two: bool, interface: Interface, name: str) -> None:
    """Add the element of model exchange or co-simulation with its capabilities; FMI 2.0 lists the sources, too."""
    store = (
        ("canGetAndSetFMUstate", "canSerializeFMUstate") if two else ("canGetAndSetFMUState", "canSerializeFMUState")
    )
    about = {"modelIdentifier": name, **dict.fromkeys(store, "true")}
    about["providesDirectionalDerivative" if two else "providesDirectionalDerivatives"] = "true"
    if interface == "me" and not two and (subject.groups["M"] or subject.groups["G"]):
        about["needsCompletedIntegratorStep"] = "true"  # which is the default of FMI 2.0
    if interface == "cs":
        fixed = subject.kind == "sampled"
        about["canHandleVariableCommunicationStepSize"] = "false" if fixed else "true"
        if fixed and not two and subject.period:
            about["fixedInternalStepSize"] = repr(subject.period)
    element = SubElement(root, "ModelExchange" if interface == "me" else "CoSimulation", about)
    if two:
        sources = SubElement(element, "SourceFiles")
        for unit in UNITS:
            SubElement(sources, "File", {"name": unit})


def _units(root: Element, subject: Subject) -> None:
    units = SubElement(root, "UnitDefinitions")
    for unit in sorted({v.unit for v in subject.variables} - {"1"}):
        exponents = dimension(unit)
        element = SubElement(units, "Unit", {"name": unit})
        if all(e.denominator == 1 for e in exponents.values()):
            base = {name: str(e) for name, e in exponents.items() if name != "deg"}
            turns = int(exponents.get("deg", 0))
            SubElement(element, "BaseUnit", base | ({"factor": repr(_DEGREE**turns)} if turns else {}))


def _variables(root: Element, subject: Subject, two: bool) -> None:
    """Add the variables; a derivative names its state by index from 1 in FMI 2.0, by value reference in FMI 3.0."""
    first_state, first_rate = subject.first("Q"), subject.first("D")
    parent = SubElement(root, "ModelVariables")
    for reference, variable in enumerate(subject.variables):
        about = {"name": variable.name, "valueReference": str(reference)}
        if variable.name != variable.description:
            about["description"] = variable.description
        kind = _kind(variable)
        value = _value(variable)
        if variable.role == "derivative":
            state = first_state + reference - first_rate
            value["derivative"] = str(state + 1 if two else state)
        if two:
            SubElement(SubElement(parent, "ScalarVariable", about | kind), "Real", value)
        else:
            SubElement(parent, "Float64", about | kind | value)


def _kind(variable: Variable) -> dict[str, str]:
    """Return causality, variability and initial of a variable, which follow from its role."""
    table: dict[str, tuple[str, str, str | None]] = {
        "time": ("independent", "continuous", None),
        "parameter": ("parameter", "fixed", "exact"),
        "constant": ("local", "constant", "exact"),
        "input": ("input", "continuous", None),
        "state": ("local", "continuous", "exact"),
        "derivative": ("local", "continuous", "calculated"),
        "output": ("output", "continuous", "calculated"),
        "discrete": ("output", "discrete", "calculated"),
        "local": ("local", "continuous", "calculated"),
    }
    causality, variability, initial = table[variable.role]
    return {"causality": causality, "variability": variability} | ({"initial": initial} if initial else {})


def _value(variable: Variable) -> dict[str, str]:
    """Return the attributes for unit, start and finite bounds of a variable."""
    value = {} if variable.unit == "1" else {"unit": variable.unit}
    if variable.role in ("parameter", "constant", "input", "state"):
        value["start"] = repr(variable.start)
    lower, upper = variable.bounds
    if math.isfinite(lower):
        value["min"] = repr(float(lower))
    if math.isfinite(upper):
        value["max"] = repr(float(upper))
    return value


def _structure(root: Element, subject: Subject, two: bool, interface: Interface) -> None:
    """Add the outputs, derivatives and initial unknowns; in FMI 3.0 also event indicators and dependencies."""
    structure = SubElement(root, "ModelStructure")
    references = range(len(subject.variables))
    outputs = [k for k in references if subject.variables[k].role in ("output", "discrete")]
    rates = [k for k in references if subject.variables[k].role == "derivative"]
    if two:
        _list(structure, "Outputs", outputs)
        _list(structure, "Derivatives", rates)
        _list(structure, "InitialUnknowns", sorted([*outputs, *rates]))
        return
    limits = [k for k in references if subject.variables[k].role == "local"] if interface == "me" else []
    groups = {
        "Output": outputs,
        "ContinuousStateDerivative": rates,
        "InitialUnknown": sorted([*outputs, *rates]),
        "EventIndicator": limits,
    }
    for name, group in groups.items():
        roles = ("time", "input", "state", *(["parameter"] if name == "InitialUnknown" else []))
        known = " ".join(str(k) for k in references if subject.variables[k].role in roles)
        for k in group:  # the standard's default, written out because CasADi's importer needs it
            SubElement(structure, name, {"valueReference": str(k), "dependencies": known})


def _list(structure: Element, name: str, places: Sequence[int]) -> None:
    if places:
        parent = SubElement(structure, name)
        for k in places:
            SubElement(parent, "Unknown", {"index": str(k + 1)})
