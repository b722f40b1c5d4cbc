# SPDX-License-Identifier: Apache-2.0
"""Time of a comparison of equations, and the share of right answers.

Run: python -m benchmarks.diff
"""

from __future__ import annotations

import dataclasses
import random
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from time import perf_counter

from benchmarks.machine import command_line, machine, table, write
from mehvar.codegen.diff import Document, compare
from mehvar.codegen.diff.changes import Change, replaced
from mehvar.codegen.diff.report import EquationVerdict, Kind
from mehvar.codegen.diff.report import Path as Place
from mehvar.codegen.equal.pool import Pool
from mehvar.codegen.equations.formula import Printer

MODELS = ("triangle", "slosh", "satellite")
EDITS = 60
SEED = 2604
GENERATED = Path(__file__).parents[1] / "generated"
Edit = Callable[[Pool, int, random.Random], Change | None]


def main() -> None:
    """Measure, and write the page."""
    with tempfile.TemporaryDirectory() as scratch:
        pendulums = {count: _slosh(count, Path(scratch)) for count in (2, 8, 16)}
    documents = {name: Document.read(GENERATED / name) for name in MODELS}
    lines = [
        "# Comparing equations",
        "",
        "Written by `python -m benchmarks.diff`. Times are those of the engine alone, one run each,",
        "without reading git, printing or running models.",
        "",
        "## Machine",
        "",
        *machine(),
        "",
        "## One flipped Coriolis sign in slosh",
        "",
        "The first velocity term of the equation of phi of the last pendulum has its sign flipped.",
        "",
        *table(
            ["pendulums", "rows", "nodes", "s", "source found", "edit found"],
            [_coriolis(n, d) for n, d in pendulums.items()],
        ),
        "",
        "## Starting",
        "",
        f"Importing the engine in a fresh process takes {_importing():.2f} s more than starting Python.",
        "",
        "## Random edits",
        "",
        f"{EDITS} edits of each model, one a comparison, in a definition, of a kind and at a place drawn with seed",
        f"{SEED}: a sign flipped, a term lost, a symbol replaced by another of the same definition, a coefficient",
        "doubled. An edit that leaves the function as it was is drawn again.",
        "",
        *table(
            ["model", "edits", "source right", "one edit reported", "kind as made", "undecided", "mean s", "largest s"],
            [_random(name, document) for name, document in documents.items()],
        ),
        "",
        "*Kind as made* asks for the same word: an edit that can be read in two ways, such as a sign in front of a",
        "product of two differences, counts as missed where the other reading was reported.",
    ]
    write("diff.md", lines)


def _slosh(count: int, scratch: Path) -> Document:
    if count == 2:
        return Document.read(GENERATED / "slosh")
    code = (
        "import sys; from mehvar.codegen.equations.graph import equations_json\n"
        "from mehvar.models.slosh.system import system\n"
        f"print(equations_json(system(pendulums='{count}')))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return Document.parse(done.stdout)


def _importing() -> float:
    """Return the median time of five starts, minus the median start of Python."""

    def seconds(code: str) -> float:
        start = perf_counter()
        subprocess.run([sys.executable, "-c", code], check=True)
        return perf_counter() - start

    return sorted(seconds("import mehvar.codegen.diff") - seconds("pass") for _ in range(5))[2]


def _coriolis(count: int, document: Document) -> list[str]:
    name = f"k_phi{count}"
    row = document.named[name]
    printer = Printer(document.nodes)
    _, path = min(_summands(document, row.node), key=lambda term: (len(term[1]), printer.text(term[0])))
    new = _edited(document, name, lambda pool, root, _: _flip(pool, root, path), random.Random(0))
    start = perf_counter()
    result = compare(document, new)
    seconds = perf_counter() - start
    right = [source.name for source in result.sources] == [name]
    edits = result[name].edits
    exact = len(edits) == 1 and edits[0].kind is Kind.SIGN and edits[0].old is not None
    same = exact and path in edits[0].old.places
    return [
        str(count), str(len(document.rows)), str(len(document.nodes)), f"{seconds:.1f}", "yes" if right else "NO",
        "yes" if same else "NO",
    ]  # fmt: skip


def _summands(document: Document, root: int) -> Iterator[tuple[int, Place]]:
    yield from ((o, (k,)) for k, o in enumerate(document.nodes[root][1:]))


def _random(name: str, document: Document) -> list[str]:
    generator = random.Random(SEED)
    rows = [row.name for row in document.definitions if row.named]
    count: Counter[str] = Counter()
    times = []
    while count["edits"] < EDITS:
        target = generator.choice(rows)
        edit = generator.choice((_sign, _lost, _symbol, _doubled))
        made: list[Kind] = []

        new = _edited(document, target, partial(_noted, edit, made), generator)
        if not made:
            continue
        start = perf_counter()
        result = compare(document, new)
        seconds = perf_counter() - start
        if not result.differs:
            count["without effect"] += 1
            continue
        times.append(seconds)
        count["edits"] += 1
        count["undecided"] += bool(result.of(EquationVerdict.UNDECIDED))
        if [source.name for source in result.sources] == [target]:
            count["source"] += 1
            edits = result[target].edits
            count["one"] += len(edits) == 1 and result[target].replayed
            count["kind"] += len(edits) == 1 and edits[0].kind is made[0]
    return [
        name, str(EDITS), str(count["source"]), str(count["one"]), str(count["kind"]), str(count["undecided"]),
        f"{sum(times) / len(times):.2f}", f"{max(times):.1f}",
    ]  # fmt: skip


def _noted(edit: Edit, made: list[Kind], pool: Pool, root: int, generator: random.Random) -> Change | None:
    change = edit(pool, root, generator)
    made += [] if change is None else [change.kind]
    return change


def _edited(document: Document, name: str, edit: Edit, generator: random.Random) -> Document:
    pool = Pool()
    numbers = pool.copy(document.nodes)
    root = numbers[document.named[name].node]
    change = edit(pool, root, generator)
    node = root if change is None else replaced(pool, root, [change])
    rows = [
        dataclasses.replace(row, node=node if row.named and row.name == name else numbers[row.node])
        for row in document.rows
    ]
    cut = len(document.definitions)
    return dataclasses.replace(
        document, nodes=tuple(pool.nodes), definitions=tuple(rows[:cut]), results=tuple(rows[cut:])
    )


def _places(pool: Pool, root: int) -> list[tuple[str, int, Place]]:
    """Return every part of an expression with the operation above it."""
    result, stack = [], [(root, ())]
    while stack and len(result) < 2000:
        node, path = stack.pop()
        for k, operand in enumerate(pool.nodes[node][1:]):
            if isinstance(operand, int):
                result.append((pool.nodes[node][0], operand, (*path, k)))
                stack.append((operand, (*path, k)))
    return result


def _terms(pool: Pool, root: int) -> list[tuple[int, Place]]:
    return [(node, path) for operation, node, path in _places(pool, root) if operation == "add"]


def _flip(pool: Pool, root: int, path: Place) -> Change:
    node = root
    for k in path:
        node = pool.operands(node)[k]
    new = pool.many("mul", [node, pool.number(-1)])
    return Change(Kind.SIGN, path, node, new, new, "", 0.0)


def _sign(pool: Pool, root: int, generator: random.Random) -> Change | None:
    terms = _terms(pool, root)
    return _flip(pool, root, generator.choice(terms)[1]) if terms else None


def _lost(pool: Pool, root: int, generator: random.Random) -> Change | None:
    terms = _terms(pool, root)
    if not terms:
        return None
    node, path = generator.choice(terms)
    return Change(Kind.TERM_REMOVED, path, node, None, None, "", 0.0)


def _doubled(pool: Pool, root: int, generator: random.Random) -> Change | None:
    terms = _terms(pool, root)
    if not terms:
        return None
    node, path = generator.choice(terms)
    new = pool.many("mul", [node, pool.number(2)])
    return Change(Kind.COEFFICIENT, path, node, new, new, "", 0.0)


def _symbol(pool: Pool, root: int, generator: random.Random) -> Change | None:
    symbols = [(node, path) for _, node, path in _places(pool, root) if pool.nodes[node][0] == "sym"]
    others = sorted({node for node, _ in symbols})
    if len(others) < 2:
        return None
    node, path = generator.choice(symbols)
    new = generator.choice([other for other in others if other != node])
    return Change(Kind.SYMBOL, path, node, new, new, "", 0.0)


if __name__ == "__main__":
    command_line(__doc__).parse_args()
    main()
