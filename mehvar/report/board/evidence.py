# SPDX-License-Identifier: Apache-2.0
"""Evidence about a law in an image, as Markdown and JSON."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from mehvar.runtime.board.evidence.branches import Condition
from mehvar.runtime.board.evidence.collect import Evidence
from mehvar.runtime.board.evidence.foreign import Inspection
from mehvar.runtime.board.evidence.misra import Findings
from mehvar.runtime.board.evidence.trace import Traced
from mehvar.runtime.files import filling

_COMPILERS = "gcc has -fcondition-coverage from version 14 on; the compilers used here do not measure MC/DC"


EVIDENCE_NAMES = ("evidence.md", "evidence.json")


def write_evidence(evidence: Evidence, misra: Findings | None, out: Path, maker: str) -> None:
    """Write evidence.md and evidence.json into a folder, with the command that made them."""
    with filling(out, maker) as folder:
        (folder / "evidence.md").write_text("\n".join(_page(evidence, misra)) + "\n", encoding="utf-8")
        (folder / "evidence.json").write_text(
            json.dumps(evidence_facts(evidence, misra), indent=1) + "\n", encoding="utf-8"
        )


def write_inspection(found: Inspection, law: str, out: Path, maker: str) -> None:
    """Write evidence.md and evidence.json about another project's image, with the command that made them."""
    facts = {**vars(found), "path": str(found.path), "functions": [vars(f) for f in found.functions],
             "members": None if found.members is None else [vars(m) for m in found.members]}  # fmt: skip
    with filling(out, maker) as folder:
        (folder / "evidence.md").write_text("\n".join(_inspection(found, law)) + "\n", encoding="utf-8")
        (folder / "evidence.json").write_text(json.dumps(facts, indent=1) + "\n", encoding="utf-8")


def _inspection(found: Inspection, law: str) -> Iterator[str]:
    """Yield the lines of the page about another project's image, which is not run."""
    yield f"# {law} in {found.path.name}: evidence"
    yield ""
    yield f"SHA-256 of the image {found.sha256}. From its instructions alone: nothing was run, no bits were compared."
    yield ""
    yield f"{found.flash} bytes of flash, {found.ram} of static data, in the whole image."
    yield f"Double-precision routines: {', '.join(found.doubles) or 'none'}."
    rows = [
        (f"`{f.function}`", f.size, f.own, _decided(f.loops), len(f.calls), _decided(f.depth), f.indirect,
         "yes" if f.recursive else "no",         _decided(f.bound), _decided(f.stack))
        for f in found.functions
    ]  # fmt: skip
    head = ("function", "bytes", "instructions", "loops", "functions called", "depth of calls",
            "calls through a register", "recursive", "instructions of a call, at most",
            "bytes of stack, at most")  # fmt: skip
    yield from _section("Functions", _table(head, rows))
    reasons = [f"- `{f.function}`: {reason}" for f in found.functions for reason in f.reasons]
    if reasons:
        yield from _section("Undecided", iter(reasons))
    if found.members is not None:
        origins = [(f"`{f.function}`", f.origin or "not in the map") for f in found.functions]
        yield from _section("Object files", _table(("function", "object file"), origins))
        members = [(m.member, m.file, f"`{m.symbol}`") for m in found.members]
        none = iter(("None: the image takes nothing from a library.",))
        table = _table(("member", "asked for by", "for"), members) if members else none
        yield from _section("Members of libraries in the image", table)


def _decided(value: int | None) -> str:
    return "undecided" if value is None else str(value)


def evidence_facts(evidence: Evidence, misra: Findings | None) -> dict[str, Any]:
    """Return the evidence as plain values for JSON."""
    run = evidence.run
    assert run.elf is not None
    return {
        "model": run.image.program.layout.model,
        "controller": run.image.program.layout.law,
        "compiler": run.image.toolchain.version,
        "sha256": evidence.sha256,
        "hash": run.image.program.layout.hash.hex(),
        "max_ulp": run.max_ulp,
        "samples": len(run.board.u_cmd),
        "disturbed": evidence.disturbed,
        "traced": [
            {"number": t.number, "title": t.title, "name": t.name, "lines": t.lines, "addresses": t.addresses}
            for t in evidence.traced
        ],
        "lengths": [vars(length) for length in evidence.lengths],
        "stack": {"used": run.stats["stack_used"], "bound": run.bound.bytes if run.bound else None},
        "coverage": [vars(reached) for reached in evidence.reached],
        "conditions": [
            {"function": c.function, "address": c.address, "text": c.text, "outcomes": sorted(c.outcomes)}
            for c in evidence.conditions
        ],
        "misra": None
        if misra is None
        else [{"rule": rule, "file": file, "findings": n} for (rule, file), n in sorted(misra.items())],
    }


def _page(evidence: Evidence, misra: Findings | None) -> Iterator[str]:
    """Yield the lines of the page about a law in mehvar's own image, which an emulator has run."""
    run = evidence.run
    layout, board = run.image.program.layout, run.image.board
    assert board is not None
    yield f"# {layout.model} under {layout.law}: evidence"
    yield ""
    yield f"{board.title}, {run.image.toolchain.version}, SHA-256 of the image {evidence.sha256}."
    yield "On an emulator; no silicon."
    yield ""
    yield f"Against this machine in float: {run.max_ulp} ulp in {len(run.board.u_cmd)} samples of the closed loop."
    yield from _section("From equation to address", _traced(evidence.traced))
    yield from _section("The longest way", _lengths(evidence))
    yield from _section("Stack", _stack(evidence))
    yield from _section("What ran", _coverage(evidence))
    yield from _section("MISRA C:2012", _misra(misra))


def _section(title: str, lines: Iterator[str]) -> Iterator[str]:
    yield ""
    yield f"## {title}"
    yield ""
    yield from lines


def _table(head: Sequence[str], rows: Sequence[Sequence[object]]) -> Iterator[str]:
    yield f"| {' | '.join(head)} |"
    yield "|---" * len(head) + "|"
    for row in rows:
        yield f"| {' | '.join(str(cell).replace('|', '/') for cell in row)} |"


def _traced(traced: Sequence[Traced]) -> Iterator[str]:
    """Yield the section that leads from numbered equations to lines of C and addresses."""
    total, numbered = sum(t.instructions for t in traced), [t for t in traced if t.number]
    yield (
        f"{len(numbered)} steps of the text have the number of an equation, {len(traced) - len(numbered)} are parts "
        f"that have none. {total} instructions of the image are of one of them, by the compiler's table of lines; a "
        "step without instructions of its own was taken into those that use it."
    )
    yield ""
    rows = [(t.number, t.title, f"`{t.name}`", _lines(t), t.instructions, _addresses(t)) for t in numbered]
    yield from _table(("equation", "what", "in C", "lines", "instructions", "addresses"), rows)


def _lines(step: Traced) -> str:
    first, last = step.lines
    return str(first) if first == last else f"{first} to {last}"


def _addresses(step: Traced) -> str:
    return ", ".join(f"{a:#x}" if a == b else f"{a:#x} to {b:#x}" for a, b in step.addresses) or "none of its own"


def _lengths(evidence: Evidence) -> Iterator[str]:
    """Yield the section on instructions of a call: upper bounds beside the observed maxima."""
    profile = evidence.run.profile
    yield (
        "Instructions of one call with all that it calls: at most, from the instructions of the image alone, and the "
        f"most that was seen. In the closed loop alone a sample took up to {profile.most if profile else 'unknown'}."
    )
    yield ""
    rows = [
        (f"`{w.function}`", w.bound if w.bound is not None else f"unbounded: {w.reason}", w.seen)
        for w in evidence.lengths
    ]
    yield from _table(("function", "at most", "seen"), rows)
    if any(w.bound is None for w in evidence.lengths):
        yield ""
        yield "A function that is unbounded by itself is bounded where its caller's arguments are constants."


def _stack(evidence: Evidence) -> Iterator[str]:
    run = evidence.run
    if run.bound is None:
        yield "No bound: the program is recursive, or a frame has a variable size."
        return
    yield f"{run.bound.bytes} bytes at most, a fault at the worst place included; {run.stats['stack_used']} were used."
    yield ""
    yield from _table(("function", "bytes"), [(f"`{name}`", size) for name, size in run.bound.chain])


def _coverage(evidence: Evidence) -> Iterator[str]:
    """Yield the section on coverage: outcomes of all conditions, and those that lack one."""
    conditions = evidence.conditions
    both = sum(len(c.outcomes) == 2 for c in conditions)
    yield (
        f"{len(evidence.run.board.u_cmd)} samples of the closed loop and {evidence.disturbed} steps from memories, "
        "parameters and measurements that were drawn. Each condition of the source is a conditional branch or an IT "
        f"block of the image; {both} of {len(conditions)} went both ways. That is coverage of conditions and decisions "
        f"in the machine's code, and no MC/DC: {_COMPILERS}."
    )
    yield ""
    rows = [(f"`{r.function}`", r.instructions, r.run, *_outcomes(conditions, r.function)) for r in evidence.reached]
    yield from _table(("function", "instructions", "ran", "conditions", "went both ways"), rows)
    missed = [c for c in conditions if len(c.outcomes) < 2]
    if missed:
        yield ""
        yield "Conditions that went one way, or were not reached:"
        yield ""
        places = [
            (f"{c.address:#x}", f"`{c.function}`", "{}:{}".format(*evidence.lines[c.address]), f"`{c.text}`", _seen(c))
            for c in missed
        ]
        yield from _table(("address", "function", "line", "instruction", "seen"), places)


def _outcomes(conditions: Sequence[Condition], function: str) -> tuple[int, int]:
    own = [c for c in conditions if c.function == function]
    return len(own), sum(len(c.outcomes) == 2 for c in own)


def _seen(condition: Condition) -> str:
    if not condition.outcomes:
        return "not reached"
    return "holds" if True in condition.outcomes else "does not hold"


def _misra(misra: Findings | None) -> Iterator[str]:
    """Yield the section on cppcheck's findings, in the order of the rules' numbers."""
    if misra is None:
        yield "Not run: cppcheck is not installed (`apt-get install cppcheck`)."
        return
    yield (
        "Findings of cppcheck's addon in law and firmware. Why each rule is not kept stands in mehvar's record of "
        "deviations (`docs/reference/misra.md`)."
    )
    yield ""
    rules = sorted({rule for rule, _ in misra}, key=lambda rule: [int(part) for part in rule.split(".")])
    rows = [
        (rule, sum(n for (r, _), n in misra.items() if r == rule),
         ", ".join(sorted(file for r, file in misra if r == rule)))
        for rule in rules
    ]  # fmt: skip
    yield from _table(("rule", "findings", "in"), rows)
