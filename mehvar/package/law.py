# SPDX-License-Identifier: Apache-2.0
"""Law as two C files, with functions on a state that the caller owns and without unused parts of the model."""

from __future__ import annotations

import hashlib
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mehvar.base.errors import bad_value, unknown_name
from mehvar.base.manifest import Parameter, Quantity
from mehvar.base.names import identifier
from mehvar.codegen.templates import text_environment
from mehvar.runtime.board.image.build import FIRMWARE, Program, delay_of
from mehvar.runtime.board.line.frames import crc32c
from mehvar.runtime.compiling.library import native_headers
from mehvar.runtime.model.generated import generated_text

TEMPLATES = Path(__file__).parents[1] / "templates" / "package"
_FUNCTION = re.compile(r"^(?:/\*[^\n]*\*/\n)?(?:static )?void (\w+)\(.*?^}\n", re.MULTILINE | re.DOTALL)
_CORE = ("mehvar/law.h", "mehvar/private/check.h", "mehvar/private/root.h")
_LARGEST = float(np.finfo(np.float32).max)


@dataclass(frozen=True)
class Vector:
    """A vector of the public header.

    Attributes
    ----------
    word : str
        Its name in the header, such as MEASURED, REFERENCE, COMMAND, PLANT, LAW or MEMORY.
    prefix : str
        Start of the enumerators of the generated C, such as SATELLITE_X.
    places : tuple of int
        Positions of its quantities in the model's vector.
    values : tuple of float
        The scenario's parameters, as floats.
    """

    word: str
    title: str
    prefix: str
    quantities: tuple[Quantity | Parameter, ...]
    places: tuple[int, ...]
    values: tuple[float, ...] = ()

    @property
    def size(self) -> int:
        """Length of its C array, at least one."""
        return max(1, len(self.places))


def law_name(firmware: Program) -> str:
    """Return the prefix of all C names of a law, such as satellite_mrac."""
    return f"{identifier(firmware.model.name)}_{identifier(firmware.law.name)}"


def law_files(firmware: Program, ranges: Mapping[str, tuple[float, float]], version: str) -> dict[str, str]:
    """Return the law's header and source, and the headers that all packages share.

    Parameters
    ----------
    ranges : mapping of str to (float, float)
        Allowed values of measurements and references by name; default: all finite ones.
    version : str
        Version of mehvar.

    Raises
    ------
    InputError
        If a range is empty or belongs to a quantity that the law does not read.
    """
    name, facts = law_name(firmware), law_facts(firmware, ranges) | {"version": version}
    environment = text_environment(TEMPLATES / "law")
    environment.filters["identifier"] = identifier
    own = {f"{name}.{end}": environment.get_template(f"NAME.{end}.j2").render(facts) for end in "hc"}
    return own | native_headers() | {path: (FIRMWARE / path).read_text(encoding="utf-8") for path in _CORE}


def law_inputs(firmware: Program) -> tuple[Quantity | Parameter, ...]:
    """Return the measurements and references that a law reads."""
    manifest = firmware.model.manifest
    functions = _functions(generated_text(manifest, f"{manifest.model}.c"), law_name(firmware))
    vectors = {vector.word: vector for vector in _vectors(firmware, "".join(functions.values()))}
    return *vectors["MEASURED"].quantities, *vectors["REFERENCE"].quantities


def law_facts(firmware: Program, ranges: Mapping[str, tuple[float, float]]) -> dict[str, Any]:
    """Return the values for the templates of a package."""
    manifest, law = firmware.model.manifest, firmware.law
    name = law_name(firmware)
    functions = _functions(generated_text(manifest, f"{manifest.model}.c"), name)
    vectors = _vectors(firmware, "".join(functions.values()))
    by = {vector.word: vector for vector in vectors}
    inputs = (*by["MEASURED"].quantities, *by["REFERENCE"].quantities)
    least, most = _ranges(ranges, inputs)
    parameters = [
        {"name": q.name, "unit": q.unit, "value": _number(value), **_bounds(q)}
        for word in ("PLANT", "LAW")
        for q, value in zip(by[word].quantities, by[word].values, strict=True)
        if isinstance(q, Parameter)
    ]
    groups = (by["PLANT"].values, by["LAW"].values, least, most)
    checksum = crc32c(bytes(4) + b"".join(np.array(_filled(v), "<f4").tobytes() for v in groups))
    block = (f"{name.upper()}_LAYOUT", f"0x{checksum:08x}u", "MV_LAW_REPORT", *map(_list, groups))
    return {
        "name": name, "NAME": name.upper(), "Camel": _camel(name),
        "model": manifest.model, "law": law, "vectors": vectors,
        "period": firmware.period, "delay": delay_of(law),
        "layout": _layout(vectors, name), "block": _members(block),
        "sizes": {word: vector.size for word, vector in by.items()}, "inputs": max(1, len(inputs)),
        "parameters": parameters, "functions": _apart(functions), "names": _names(vectors, name),
        **_calls(name, bool(law.memory), f"{name}_start" in functions),
    }  # fmt: skip


def _camel(name: str) -> str:
    return "".join(word[:1].upper() + word[1:] for word in name.split("_"))


def _functions(text: str, name: str) -> dict[str, str]:
    """Return the law's functions and the functions they call, in the order of the generated C."""
    texts = {match[1]: match[0] for match in _FUNCTION.finditer(text)}
    needed, rest = set(), [name, *([start] if (start := f"{name}_start") in texts else [])]
    while rest:
        needed.add(function := rest.pop())
        rest += (set(re.findall(r"\w+(?=\()", texts[function])) & texts.keys()) - needed
    return {function: body for function, body in texts.items() if function in needed}


def _apart(functions: Mapping[str, str]) -> str:
    """Return the text of the functions, declared static."""
    return "\n".join(
        re.sub(r"^(static )?void", "APART void", f, count=1, flags=re.MULTILINE) for f in functions.values()
    )


def _vectors(firmware: Program, text: str) -> tuple[Vector, ...]:
    """Return the vectors of the public header; except for memory and command, only elements that the law reads."""
    manifest, law = firmware.model.manifest, firmware.law
    model, name = identifier(manifest.model).upper(), law_name(firmware).upper()
    period = f"{1000 * firmware.period:g} ms"
    rows: tuple[tuple[str, str, str, Sequence[Quantity | Parameter], bool], ...] = (
        ("MEASURED", "measurements", f"{model}_X", manifest.seen, bool(manifest.measured)),
        ("REFERENCE", "references", f"{model}_R", manifest.references, False),
        ("COMMAND", f"commands, every {period}", f"{model}_U", manifest.inputs, True),
        ("PLANT", "parameters of the plant", f"{model}_P", manifest.parameters, False),
        ("LAW", "parameters of the law", f"{name}_C", law.parameters, False),
        ("MEMORY", "memory, which no one else writes", f"{name}_Z", law.memory, True),
    )
    numbers: dict[str, Sequence[float]] = {"PLANT": firmware.resolved.p.tolist(), "LAW": firmware.resolved.c.tolist()}
    return tuple(_vector(*row, text=text, values=numbers.get(row[0], ())) for row in rows)


def _vector(
    word: str,
    title: str,
    prefix: str,
    quantities: Sequence[Quantity | Parameter],
    whole: bool,
    text: str,
    values: Sequence[float],
) -> Vector:
    """Return the elements of a vector that the C text uses; all of them for `whole` and for text with loops."""
    used = set(re.findall(rf"\b{prefix}_(\w+)", text))
    loops = "for (" in text  # indices are then computed from the first of a family
    places = [k for k, q in enumerate(quantities) if whole or loops or identifier(q.name).upper() in used]
    own = tuple(float(np.float32(values[k])) for k in places) if len(values) else ()
    return Vector(word, title, prefix, tuple(quantities[k] for k in places), tuple(places), own)


def _names(vectors: Sequence[Vector], name: str) -> list[tuple[str, str]]:
    """Return pairs of constants, each of the generated functions and of the public header."""
    return [
        (f"{v.prefix}_{word}", f"{name.upper()}_{v.word}_{word}")
        for v in vectors
        for word in (identifier(q.name).upper() for q in v.quantities)
    ]


def _layout(vectors: Sequence[Vector], name: str) -> str:
    """Return a 32-bit hash of the law's inputs and parameters."""
    rows = [(v.word, [(q.name, q.unit) for q in v.quantities]) for v in vectors if v.word != "MEMORY"]
    return hashlib.sha256(repr((name, rows)).encode()).hexdigest()[:8]


def _ranges(
    ranges: Mapping[str, tuple[float, float]], inputs: Sequence[Quantity | Parameter]
) -> tuple[list[float], list[float]]:
    """Return the least and the largest value of each input; without a range, those of a float."""
    names = [q.name for q in inputs]
    for name, (least, most) in ranges.items():
        if name not in names:
            raise unknown_name("input of the law", name, names, "--range")
        if not -_LARGEST <= least <= most <= _LARGEST:
            raise bad_value(
                "range", f"{name}={least:g}:{most:g}", "LEAST:MOST, finite in float, LEAST <= MOST", "--range"
            )
    every = (-_LARGEST, _LARGEST)
    return [ranges.get(n, every)[0] for n in names], [ranges.get(n, every)[1] for n in names]


def _bounds(parameter: Parameter) -> dict[str, str]:
    """Return the smallest and the largest allowed float."""
    least, most = (np.float32(np.clip(b, -_LARGEST, _LARGEST)) for b in (parameter.lower, parameter.upper))
    if parameter.lower_open and float(least) <= parameter.lower:  # a closed bound rounds as a value at it does
        least = np.nextafter(least, np.float32(np.inf))
    if parameter.upper_open and float(most) >= parameter.upper:
        most = np.nextafter(most, np.float32(-np.inf))
    return {"least": _number(float(least)), "most": _number(float(most))}


def _calls(name: str, memory: bool, starts: bool) -> dict[str, str]:
    reference = f"in + {name.upper()}_NMEASURED"
    call = f"{name}(in, {reference}, block->plant, block->law, command)"
    if memory:
        remembered = "law->applied, law->memory[law->half]"
        call = f"{name}(in, {reference}, {remembered}, block->plant, block->law, command, next)"
    first = f"in, {reference}, law->parameters->plant, law->parameters->law, law->memory[law->half]"
    return {"call": call if memory else f"(void)next;\n    {call}", "start": f"{name}_start({first})" if starts else ""}


def _filled(values: Sequence[float]) -> Sequence[float]:
    """Return the elements of a C array, at least one."""
    return values or [0.0]


def _members(texts: Sequence[str]) -> str:
    """Return the members of a C struct, one line each."""
    return "{\n" + "".join(f"    {text},\n" for text in texts) + "}"


def _list(values: Sequence[float]) -> str:
    return f"{{{', '.join(map(_number, _filled(values)))}}}"


def _number(value: float) -> str:
    if math.isinf(value):
        return "(1.0f / 0.0f)" if value > 0 else "(-1.0f / 0.0f)"
    return f"{float(np.float32(value)).hex()}f"
