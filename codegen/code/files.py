# SPDX-License-Identifier: Apache-2.0
"""C, header and Python files of a model, filled into templates."""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Hashable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

from mehvar.base.constants import vectors
from mehvar.base.manifest import PREPARED, Array, Manifest, Part, Signature, file_of, result_shape
from mehvar.base.names import identifier

from ..functions.function import FunctionGraph
from ..templates import text_environment
from .labels import PLAIN, Labels, Names, names_of
from .loops import loops
from .members import Tags, in_order, members
from .rolled import RolledPrinter
from .spelling import PYTHON, C, Language, Printer
from .split import split
from .tape import Tape, arranged, tape

Families = Mapping[str, tuple[tuple[Hashable, int], ...]]
"""For each vector, the part (such as a pendulum) of each element, and the element's name in that part."""
_TEMPLATES = Path(__file__).parent / "templates"
_TITLES: dict[Part, str] = {
    "": "",
    "variants": ", as the choices of a run vary it",
    "prepared": ", in two parts for many calls of a run",
    "variants_prepared": ", its variants in two parts for many calls of a run",
    "jac": ", Jacobians",
    "outputs_jac": ", Jacobians of the outputs",
    "parameters_jac": ", Jacobians with respect to the parameters",
    "loops_jac": ", derivatives of the laws and of the closed loops",
}


@dataclass(frozen=True)
class PrintedFunction:
    """A generated function: its list of instructions, and its C and Python text."""

    name: str
    description: str
    arguments: Signature
    results: Signature
    part: Part
    tape: Tape
    labels: Labels = PLAIN
    families: Families = field(default_factory=dict)
    change: PrintedFunction | None = None
    """For a Jacobian, the directional derivative that gives its columns in Python, and in C if the tape is empty."""

    @property
    def operations(self) -> int:
        """Operations of one evaluation."""
        if self.change and self.by_columns:
            return self.change.operations * sum(count for _, _, count in self.matrices)
        return self.tape.operations

    @property
    def chain(self) -> int:
        """Operations that one evaluation computes one after the other, because each needs the one before."""
        return self.change.chain if self.change and self.by_columns else self.tape.chain

    @property
    def by_columns(self) -> bool:
        """True for a Jacobian whose columns C computes as directional derivatives."""
        return not self.tape.results

    @property
    def matrices(self) -> list[tuple[str, str, int]]:
        """For a Jacobian, its results with the name and the number of elements of the argument that each is for."""
        sizes = dict(self.arguments)
        by = [(name, self.name[-1] if name == "J" else name.removeprefix("J_")) for name, _ in self.results]
        return [(name, argument, sizes[argument] or 0) for name, argument in by]

    def c_signature(self, real: str) -> str:
        """Return the parameters of the C function: the public function has the type `mv_real`, its body `real`."""
        arguments = [f"const {real} *{name}" for name, _ in self.arguments]
        return ", ".join(arguments + [f"{real} *{name}" for name, _ in self.results])

    @property
    def unused(self) -> list[str]:
        """Names of unused arguments, and of results without elements."""
        if self.by_columns:
            return []
        read = {i.args[0] for i in self.tape.instructions if i.op == "input"}
        unread = [name for k, (name, _) in enumerate(self.arguments) if k not in read]
        return unread + [name for name, size in self.results if size == 0]

    @property
    def places(self) -> dict[str, tuple[str, ...]]:
        """C names of positions in the vectors between the parts of a split function."""
        return {name: self.labels.constants[name] for name, _ in self.results if name in self.labels.parts}

    @property
    def c_lines(self) -> list[str]:
        """Body of the C function."""
        several = loops(self.tape, self.tags)
        if several is not None:
            return RolledPrinter(self.tape, self.arguments, self.results, self.labels, several).body()
        lines, results = self._statements(C)
        for (name, _), elements in zip(self.results, results, strict=True):
            constants = self.labels.constants.get(name)
            for k, value in enumerate(elements):
                lines += f"{name}[{constants[k] if constants else k}] = {value};".split("\n")
        return lines

    @cached_property
    def tags(self) -> Tags:
        """Elements of arguments, with the equal parts that they belong to."""
        return tags_of(self.arguments, self.families)

    @property
    def python_lines(self) -> list[str]:
        """Body of the Python function with its return statement."""
        if self.change:
            point, sizes = ", ".join(name for name, _ in self.arguments), dict(self.arguments)
            along = [name.removeprefix("along_") for name, _ in self.change.arguments[len(self.arguments) :]]
            counts = tuple(sizes[name] for name in along)
            columns = (f"{self.change.name}, ({point}), {counts}, {along.index(by)}" for _, by, _ in self.matrices)
            return [f"return {', '.join(f'_columns({arguments})' for arguments in columns)}"]
        lines, values = self._statements(PYTHON)
        returned = [self._python_result(result, v) for result, v in zip(self.results, values, strict=True)]
        return [*lines, *f"return {', '.join(returned)}".split("\n")]

    def _statements(self, language: Language) -> tuple[list[str], list[list[str]]]:
        return Printer(self.tape, self.arguments, language, self.labels, self._names).print()

    @cached_property
    def _names(self) -> Names:
        return names_of(self.tape, self.arguments, self.labels, [name for name, _ in self.results])

    def _python_result(self, result: Array, values: list[str]) -> str:
        if result[1] is None:
            return f"np.asarray({values[0]})[()]"
        elements = "".join(f"\n    {value.replace(chr(10), chr(10) + '    ')}," for value in values)
        vector = f"_vector({elements}\n)" if values else "_vector()"
        shape = result_shape(self.name, result, self.arguments)
        if len(shape) == 1:
            return vector
        return f"(lambda J: J.reshape(*J.shape[:-1], {shape[0]}, {shape[1]}))({vector})"

    def result_families(self, result: int) -> tuple[tuple[Hashable, int], ...]:
        """Return for each element of a result the kind and number of its part, such as a pendulum."""
        found = members(self.tape, self.tags)
        if found is None:
            return ()
        return tuple(
            (found.kind.get(k, ""), found.owner[k] if k in found.kind else 0) for k in self.tape.results[result]
        )

    def names_of(self, result: int) -> tuple[str, ...]:
        """Return the names of a result's elements in the code."""
        values = self.tape.results[result]
        names = names_of(self.tape, self.arguments, self.labels, [name for name, _ in self.results], values)
        return tuple(names.values[k] for k in values)


def printed_functions(functions: Sequence[FunctionGraph]) -> list[PrintedFunction]:
    """Print each graph as C and Python; a split function is also printed in two parts."""
    whole = [
        PrintedFunction(f.name, f.description, f.arguments, f.results, f.part, _tape(f), _labels(f), f.families)
        for f in functions
    ]
    by_name = {p.name: p for p in whole}
    whole = [replace(p, change=by_name[f.change]) if f.change else p for p, f in zip(whole, functions, strict=True)]
    parts = (_in_parts(p, f.parameters, f.held) for p, f in zip(whole, functions, strict=True))
    return [*whole, *(part for several in parts for part in several)]


def _tape(f: FunctionGraph) -> Tape:
    """Convert a graph to a list of instructions, with sums over equal parts in an order that a loop can compute.

    A Jacobian by columns has no instructions of its own.
    """
    if not f.graph.is_a("SXFunction"):
        return Tape((), ())
    plain, tags = tape(f.graph, f.parameters, f.derivation), tags_of(f.arguments, f.families)
    ordered = in_order(plain, tags, f.parameters)
    return plain if ordered is plain else arranged(ordered, f.derivation)


def tags_of(arguments: Signature, families: Families) -> Tags:
    """Return the elements of arguments that belong to equal parts, such as pendulums."""
    return {
        (place, k): tag
        for place, (name, _) in enumerate(arguments)
        for k, tag in enumerate(families.get(name, ()))
        if tag[1]
    }


def _labels(f: FunctionGraph) -> Labels:
    return Labels(elements=f.elements, numbers=f.derivation.numbers if f.derivation else {})


def _in_parts(f: PrintedFunction, parameters: frozenset[int], held: frozenset[int]) -> list[PrintedFunction]:
    """Return the parts of a function that a run computes once per run and once per sample; empty if there are none."""
    rest, constant, parts = f, {f.arguments[k][0] for k in parameters}, list[PrintedFunction]()
    steps: tuple[tuple[str, str, str, set[str]], ...] = (
        ("prepare", "h", "once per run", set()),
        ("hold", "w", "when the input changes", {"u"} if held else set()),
    )
    for step, vector, when, more in steps if constant else ():
        constant |= more
        places = {k for k, (name, _) in enumerate(rest.arguments) if name in constant}
        halves = split(rest.tape, rest.arguments, places, vector)
        if halves is None:
            continue
        once, result = f"part of {f.name} that is computed {when}", (Array(vector, halves.size),)
        part = PrintedFunction(
            f"{f.name}_{step}", once, halves.first, result, PREPARED[f.part], halves.prepare, rest.labels, rest.families
        )
        labels = _with_part(rest.labels, f"{f.name}_{vector}", vector, part.names_of(0))
        parts.append(replace(part, labels=labels))
        families = {**rest.families, vector: part.result_families(0)}
        rest = replace(rest, arguments=halves.second, tape=halves.prepared, labels=labels, families=families)
        constant |= {vector}
    if not parts:
        return []
    return [
        *parts,
        replace(rest, name=f"{f.name}_prepared", description=f"the rest of {f.name}", part=PREPARED[f.part]),
    ]


def _with_part(labels: Labels, prefix: str, vector: str, names: tuple[str, ...]) -> Labels:
    return replace(
        labels,
        elements={**labels.elements, vector: names},
        constants={**labels.constants, vector: tuple(f"{prefix}_{name}" for name in names)},
        parts=labels.parts | {vector},
    )


def _placed(f: PrintedFunction, manifest: Manifest) -> PrintedFunction:
    """Rename a function's vector positions to the names of the header."""
    named = {vector.prefix: vector.names for vector in vectors(manifest)}
    laws = [identifier(law) for law in manifest.controllers]
    own = [law for law in laws if f.name == law or f.name.startswith(f"{law}_")]
    constants = {}
    for vector, elements in f.labels.elements.items():
        letter = vector.upper()
        for prefix in (*(f"{law.upper()}_{letter}" for law in sorted(own, key=len, reverse=True)), letter):
            if named.get(prefix) == elements:
                constants[vector] = tuple(f"{manifest.model}_{prefix}_{name}".upper() for name in elements)
                break
    return replace(f, labels=replace(f.labels, constants={**constants, **f.labels.constants}))


def model_hash(manifest: Manifest, functions: Sequence[PrintedFunction]) -> str:
    """Return a hash of the operations of all generated functions and of their argument names."""
    digest = hashlib.sha256(repr((manifest.model, sorted(manifest.structure.items()))).encode())
    for vector in vectors(manifest):
        digest.update(repr([(vector.prefix, q.name, q.unit) for q in vector.quantities]).encode())
    for f in functions:
        instructions = [(i.op, i.args, i.value) for i in f.tape.instructions]
        sides = [tuple(map(tuple, side)) for side in (f.arguments, f.results)]  # pairs, as before they had names
        digest.update(repr((f.name, *sides, instructions, f.tape.results)).encode())
    return digest.hexdigest()


def code_files(
    manifest: Manifest, functions: Sequence[PrintedFunction], left_out: Collection[str] = ()
) -> dict[str, str]:
    """Return the filled templates.

    Parameters
    ----------
    manifest, functions
        As of the model.
    left_out : collection of str
        Names of files that are not written.

    Returns
    -------
    dict of str to str
        File names with contents: MODEL.h, a C file for each group of functions, and Python files.
    """
    environment = text_environment(_TEMPLATES)
    name, functions = manifest.model, [_placed(f, manifest) for f in functions]
    common = {
        "model": name,
        "title": manifest.title,
        "hash": manifest.hash,
        "vectors": vectors(manifest),
        "needs_erf": any(i.op == "erf" for f in functions for i in f.tape.instructions),
    }

    def fill(template: str, chosen: Sequence[PrintedFunction], what: str = "") -> str:
        return environment.get_template(template).render(common, functions=chosen, what=what)

    files = {f"{name}.h": fill("model.h.j2", functions)}
    for part, title in _TITLES.items():
        chosen = [f for f in functions if f.part == part]
        source, module = file_of(name, part), file_of(name, part, "py")
        if chosen and source not in left_out:
            files[source] = fill("model.c.j2", chosen, title)
        if part in ("", "variants", "outputs_jac", "parameters_jac", "loops_jac") and chosen and module not in left_out:
            own = [f for f in functions if not part and f.part == "jac"]
            files[module] = fill("model.py.j2", [*chosen, *own], title)
    return files
