# SPDX-License-Identifier: Apache-2.0
"""`mehvar diff --paper`: what the papers print, judged by the derivation; as text, JSON or an HTML page.

Judging needs SymPy and takes up to a minute for a paper; verdicts are kept in the cache under a hash of the sources.
"""

from __future__ import annotations

import itertools
import json
import os
import signal
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from rich.text import Text

from mehvar.codegen.generate import Tree, find_tree, installed_tree, system_of
from mehvar.comparison.text import Line, print_lines
from mehvar.errors import InputError, unknown_name
from mehvar.runtime import cache
from mehvar.terminal import working

Ledger = dict[str, Any]
_FILE = "ledger.json"
_DIFFERS, _HOLDS, _DEFINITION = "differs", "holds", "definition"
_STYLES = {_DIFFERS: "red", "undecided": "yellow", "illegible or ambiguous": "yellow"}
_WORDS = {_HOLDS: "hold", _DIFFERS: "differ", _DEFINITION: "definitions"}


def paper_command(model: str | None, form: str, out: Path | None) -> int:
    """Judge, print or save, and return the exit status: 0 if everything printed holds, else 1.

    Raises
    ------
    InputError
        If there is no such model, or it has no ledger.
    """
    from mehvar.cli.diff import deliver

    with working("judging the printed equations"):
        ledgers = judged(find_tree(Path.cwd()) or installed_tree(), model)
    if form == "text" and out is None:
        print_lines(lines(ledgers))
    else:
        deliver(_text(ledgers, form), out, [f"{ledger['model']}: {counted(ledger)}" for ledger in ledgers])
    return int(any(entry["verdict"] in _STYLES for ledger in ledgers for entry in ledger["entries"]))


def judged(tree: Tree, model: str | None = None) -> list[Ledger]:
    """Return the ledger of every model of a tree that has one, or of one model, as plain data.

    Raises
    ------
    InputError
        If there is no such model, or it has no ledger.
    """
    if model is not None and model not in tree.models:
        raise unknown_name("model", model, tree.models, str(tree.root / "models"))
    with_paper = [name for name in tree.models if _has_paper(tree, name)]
    chosen = [name for name in with_paper if model in (None, name)]
    if not chosen:
        raise InputError(f"no published equations for {model or tree.root}: there are some for {', '.join(with_paper)}")
    workers = min(len(chosen), os.cpu_count() or 1)
    ended_by_ctrl_c = (signal.SIGINT, signal.SIG_DFL)
    with (
        ProcessPoolExecutor(workers, get_context("spawn"), signal.signal, ended_by_ctrl_c) as processes,
        ThreadPoolExecutor(len(chosen)) as threads,
    ):
        return list(threads.map(lambda name: _ledger(tree, name, processes), chosen))


def counted(ledger: Ledger) -> str:
    """Count the entries by verdict, as in "31 hold, 27 differ"."""
    counts = [(count, _WORDS.get(verdict, verdict)) for verdict, count in ledger["counts"].items()]
    return ", ".join(f"{count} {word}" for count, word in counts if count)


def lines(ledgers: Sequence[Ledger]) -> Iterator[Line]:
    """Say what each paper prints that is not so, and name the rest."""
    for ledger in ledgers:
        yield 0, Text.assemble((f"{ledger['model']}: ", "bold"), counted(ledger))
        yield 0, Text(ledger["title"], "dim")
        for verdict in (_HOLDS, _DEFINITION):
            numbers = [entry["number"] for entry in ledger["entries"] if entry["verdict"] == verdict]
            if numbers:
                yield 2, Text.assemble((f"{_WORDS[verdict]}  ", "green"), ", ".join(numbers))
        for entry in ledger["entries"]:
            if entry["verdict"] in _STYLES:
                yield from _entry(entry)


def example(line: dict[str, Any]) -> str:
    """Return a counterexample in one line, or nothing."""
    found = line["counterexample"]
    if not found:
        return ""
    told = [f"{name} = {value}" for name, value in found["at"] if str(value) != "0"]
    if len(told) < len(found["at"]):
        told.append("the rest 0" if told else "all 0")
    where = f"at {', '.join(told)}: " if told else ""
    return f"{where}left side {found['left']}, right side {found['right']}"


def _has_paper(tree: Tree, model: str) -> bool:
    folder = tree.root / "models" / model
    return (folder / "paper.py").is_file() or (folder / "paper" / "__init__.py").is_file()


def _ledger(tree: Tree, model: str, processes: ProcessPoolExecutor) -> Ledger:
    """Return the ledger of a model from the cache; one that is not there is judged in another process."""
    key = cache.key(*itertools.chain(*tree.sources(model, papers=True).items()))

    def fill(folder: Path) -> None:
        text = processes.submit(_judge, tree.root, model).result()
        (folder / _FILE).write_text(text, encoding="utf-8")

    path = cache.entry("ledgers", f"{model}-{key}", fill) / _FILE
    ledger: Ledger = json.loads(path.read_text(encoding="utf-8"))
    return ledger


def _judge(root: Path, model: str) -> str:
    """Derive a model and judge its paper; runs in a process of its own."""
    system = system_of(Tree(root), model, {})
    from mehvar.codegen.ledger.ledger import (
        ledger_json,  # after the model, so that both use the models package of its tree
    )

    return ledger_json(system)


def _entry(entry: dict[str, Any]) -> Iterator[Line]:
    yield (
        2,
        Text.assemble(
            (f"{entry['verdict']} ", _STYLES[entry["verdict"]]), (entry["number"], "bold"), f"  {entry['title']}"
        ),
    )
    for reading in entry["readings"]:
        if len(entry["readings"]) > 1:
            used = "the model follows this" if reading["used"] else "not used"
            yield 4, Text(f"reading {reading['text']!r}: {reading['verdict']} ({used}) {reading['why']}")
        for line in reading["lines"]:
            if line["verdict"] in _STYLES:
                yield from _relation(line)
    if entry["note"]:
        yield 4, Text(entry["note"], "dim")


def _relation(line: dict[str, Any]) -> Iterator[Line]:
    yield 4, Text(f"printed  {line['printed']}", "red")
    if line["corrected"]:
        yield 4, Text(f"correct  {line['corrected']}", "green")
    for edit in line["edits"]:
        yield 6, Text(edit)
    for text in (line["says"], example(line)):
        if text:
            yield 6, Text(text)
    yield 6, Text(line["how"], "dim")


def _text(ledgers: Sequence[Ledger], form: str) -> str:
    if form == "json":
        return json.dumps({"schema": 1, "papers": list(ledgers)}, indent=1, ensure_ascii=False) + "\n"
    if form == "html":
        from mehvar.comparison.html import paper_page

        return paper_page(ledgers)
    return "\n".join(" " * indent + text.plain for indent, text in lines(ledgers)) + "\n"
