# SPDX-License-Identifier: Apache-2.0
"""Wrong terms that the physics gates detect: every additive term of every plant and part flipped, dropped, doubled.

Run: python -m benchmarks.mutation [plants or parts]
"""

from __future__ import annotations

import re
import subprocess
import sys
from collections import Counter
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

from benchmarks.machine import command_line, table, write
from benchmarks.machine import machine as this_machine

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

from mehvar.physics.mutation import Mutant, Tally, run  # noqa: E402
from tests.mehvar.physics.declared import EVERY, Case, gates_of, title  # noqa: E402
from tests.mehvar.physics.installed import machine  # noqa: E402
from tests.models.parts import planted  # noqa: E402

PROOFS = (
    (
        "^hinge",
        r"a_K[24](.)(.): (a_J\1\2|-a_c\1\*a_c\2\*a_m)$",
        "entry ij of P J [g]' + [g] J P, with P = gg' or 1 - gg', has J_ij times P_ij ([g]_ji + [g]_ij) = 0",
    ),
    (
        "tank|by factors",
        r"(carried 1|power): -?a_bob_(de.\*a_l)$",
        "-(a + d)^2/2 + a.(a + d) is even in d = l e', and a flipped term of d is flipped wherever it is",
    ),
    (
        "tank",
        r"carried 1: ",
        "the line h from fuel to nozzle has the power v.(w x h) + w.(v x h) = 0, its moment c the power w.(w x c) = 0",
    ),
    (
        "^(ball joint|chain)$",
        r"a_[BGNHfha]\d",
        "after the elimination of its speeds, a joint along S resists no acceleration S: B S = 0 makes the term zero; "
        "the three S of a ball joint are all rotations",
    ),
    (
        "",
        r"moment_.: -?a_F.\*a_arm1_.$",
        "the gravity gradient acts at the centre of mass, from which its arm is zero",
    ),
    (
        "",
        r"orbit_lit: -?orbit_(limb|disc)",
        "a bound of the penumbra outside of it: there the clipped segments are the whole disc, or nothing",
    ),
    (
        "",
        r"(a_turn: (t/Ts|1/2)|measures .*: a_turn)$",
        "k = round(t/Ts) and its rest r by n are whole: n divides -k as k, k/n and (k + 1/2)/n have one floor, and "
        "2 r < 1/2 as r < 1/2",
    ),
)
"""Subject, owner and term of equivalent mutants as regular expressions, with the reason."""


def plants() -> None:
    """Try every wrong term of the shipped models, and write their page."""
    lines = _head()
    tallies = {case: _try(case) for case in EVERY}
    lines += ["## Killed", "", *_table(tallies), "", *_list("Equivalent", tallies, "equivalent")]
    lines += _list("Survivors", tallies, "survivors")
    for model in dict.fromkeys(model for model, _ in EVERY):
        lines += _per_gate(model, [tally for (name, _), (tally, _) in tallies.items() if name == model])
    write("mutation.md", lines)


def parts() -> None:
    """Try every wrong term of each part, and write their page."""
    tallies = {name: _try_part(name, subject) for name, subject in planted.subjects().items()}
    lines = [
        "# Wrong terms of parts that particles notice",
        "",
        f"Written by `python -m benchmarks.mutation parts` on {datetime.now(UTC):%Y-%m-%d} at commit {_commit()}.",
        "",
        "Each part is in one small craft. A mutant has one additive term changed: sign flipped, dropped, or doubled.",
        "Terms are those of what the part's methods return (masses, momenta, energies, forces, loads, rates, powers,",
        "limits, measurements, guards), and of every definition that is named after the part. A term of a mass or a",
        "momentum is wrong wherever it enters, so that all equations remain consistent. Rows `all equations` change",
        "each equation of a craft instead: those of the hub, readings, and states at the start.",
        "",
        "A mutant is killed when, at one of twelve random points (up to 400 where few reach a branch, such as the",
        "penumbra), a relative error exceeds 1e-9: that of accelerations, energy, momentum or guards against particles",
        "under Newton's law (`tests/reference/reference_parts.py`, with field and light of `reference_sky.py`), that",
        "of limits, measurements and starts against their definitions (`reference_signals.py`), or that of balances",
        "of momentum and energy.",
        "Equivalent is a mutant that changes no function by 1e-13 at 500 points. Parameters keep their defaults.",
        "",
        "## Machine",
        "",
        *this_machine(),
        "",
        "## Killed",
        "",
        *_table(tallies),
        "",
        *_proved(tallies),
        *_list("Survivors", tallies, "survivors"),
        *_per_gate("parts", [tally for tally, _ in tallies.values()]),
    ]
    write("mutation_parts.md", lines)


def _try_part(name: str, subject: planted.Subject) -> tuple[Tally, float]:
    start = process_time()
    tally = subject.tally()
    print(f"{name}: {tally.killed} of {tally.total}", file=sys.stderr, flush=True)
    return tally, process_time() - start


def _proved(tallies: Mapping[str, tuple[Tally, float]]) -> list[str]:
    """Return the equivalent mutants by the reason that they change nothing."""
    groups: Counter[tuple[str, str]] = Counter()
    for name, (tally, _) in tallies.items():
        for mutant in tally.equivalent:
            groups[name, reason(name, mutant)] += 1
    rows = [[name, str(count), why] for (name, why), count in groups.items()]
    shown = table(["part", "mutants", "they change nothing because"], rows) if rows else ["None."]
    return ["## Equivalent", "", *shown, ""]


def reason(name: str, mutant: Mutant) -> str:
    """Return why a mutant of a part is equivalent; "not proved" for one without a proof."""
    text = f"{mutant.term.owner}: {_plain(mutant.term.text)}"
    return next((why for part, term, why in PROOFS if re.search(part, name) and re.search(term, text)), "not proved")


def _plain(text: str) -> str:
    """Return a term without the weights of terms within it."""
    return re.sub(r"\*?weight_\d+(\*\*\d)?", "", text)


def _head() -> list[str]:
    return [
        "# Wrong terms that the physics gates notice",
        "",
        "Written by `python -m benchmarks.mutation plants` on "
        f"{datetime.now(UTC):%Y-%m-%d} at commit {_commit()}. What the gates are:",
        "[Physics gates](../../docs/explanation/physics-gates.md).",
        "",
        "A mutant is the plant with one additive term changed: sign flipped, dropped, or doubled. Terms are those of",
        "x', outputs, initial state, reference, regular chart and the model's own functions, and of every definition",
        "behind them, nested sums included; an expression without a sum is one term. Laws, actuators, sensors and",
        "margins are not mutated. A mutant is killed when a gate's relative error exceeds 1e-9 at one of six random",
        "points. The gates stand alone: the comparison with the derived equations, which generation makes, is not one",
        "of them. Equivalent is a mutant that no gate notices and that leaves every function of the plant unchanged,",
        "to 1e-13, at 500 random points of the ranges in `tests/sampling.py`. A side that is not finite is noticed.",
        "",
        "## Machine",
        "",
        *this_machine(),
        "",
    ]


def _try(case: Case) -> tuple[Tally, float]:
    model, structure = case
    start = perf_counter()
    subject = machine(model, *structure)
    tally = run(subject.system, subject.ranges, gates_of)
    print(f"{title(case)}: {tally.killed} of {tally.total}", file=sys.stderr, flush=True)
    return tally, perf_counter() - start


def _table(tallies: Mapping[Any, tuple[Tally, float]]) -> list[str]:
    rows = []
    for case, (v, seconds) in tallies.items():
        counts = (v.terms, v.total, v.killed, len(v.equivalent), len(v.survivors), len(v.verified))
        rows.append([_title(case), *map(str, counts), f"{seconds:.0f}"])
    total = [sum(int(row[k]) for row in rows) for k in range(1, 8)]
    columns = ["structure", "terms", "mutants", "killed", "equivalent", "survived", "of these found by generation", "s"]
    return table(columns, [*rows, ["all", *map(str, total)]])


def _title(case: Case | str) -> str:
    return case if isinstance(case, str) else title(case)


def _list(heading: str, tallies: Mapping[Any, tuple[Tally, float]], kind: str) -> list[str]:
    result: list[tuple[Any, Mutant]] = [(case, m) for case, (v, _) in tallies.items() for m in getattr(v, kind)]
    rows = [[_title(case), m.term.owner, f"`{_plain(m.term.text)[:100]}`", m.change] for case, m in result]
    shown = table(["structure", "in", "term", "change"], rows) if rows else ["None."]
    return [f"## {heading}", "", *shown, ""]


def _per_gate(model: str, tallies: list[Tally]) -> list[str]:
    killers = sum((tally.killers for tally in tallies), Counter[str]())
    rows = [[gate, str(count)] for gate, count in killers.most_common()]
    return [f"## First gate to notice, {model}", "", *table(["gate", "mutants"], rows), ""]


def _commit() -> str:
    def git(*arguments: str) -> str:
        done = subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True, check=True)
        return done.stdout.strip()

    used = (
        "models",
        "mehvar/physics",
        "tests/mehvar/physics",
        "tests/models/parts",
        "tests/reference",
        "tests/sampling.py",
    )
    changed = git("status", "--porcelain", "--", *used)
    return git("rev-parse", "--short=10", "HEAD") + (", with uncommitted changes" if changed else "")


if __name__ == "__main__":
    pages = {"plants": plants, "parts": parts}
    for page in command_line(__doc__, pages).parse_args().parts or pages:
        pages[page]()
