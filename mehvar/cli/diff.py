# SPDX-License-Identifier: Apache-2.0
"""`mehvar diff`: comparison of two versions, in an output format and destination."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Annotated

import typer

from mehvar.base.errors import InputError, bad_value
from mehvar.base.names import WORK
from mehvar.codegen.workspace import find_tree, installed_tree
from mehvar.comparison.compare import diff_versions
from mehvar.comparison.markdown import markdown
from mehvar.comparison.result import Diff
from mehvar.comparison.versions.sources import names_model
from mehvar.pictures.files import checked_suffix, save
from mehvar.pictures.style import require_matplotlib
from mehvar.runtime.files import check_file, checked_ending, write_atomic
from mehvar.terminal import Line, pages, plain_text, print_lines, progress

FORMATS = ("text", "json", "html", "markdown")
_ENDINGS = {".txt": "text", ".json": "json", ".html": "html", ".md": "markdown"}
_HEAD = "HEAD"


def command(
    old: Annotated[
        str | None,
        typer.Argument(metavar="[OLD]", help="A model; or a git revision, a folder, FILE.py or `work`; default: HEAD."),
    ] = None,
    new: Annotated[
        str | None, typer.Argument(metavar="[NEW]", help="Like OLD; default: `work`, the current models/.")
    ] = None,
    model: Annotated[str | None, typer.Option(metavar="M", help="Compare this model only.")] = None,
    structures: Annotated[
        list[str] | None,
        typer.Option(metavar="all|NAME=VALUE[,...]", help="Compare other structures too; repeat as needed."),
    ] = None,
    paper: Annotated[bool, typer.Option("--paper", help="Compare with the published equations.")] = False,
    form: Annotated[
        str | None,
        typer.Option("--format", metavar="text|json|html|markdown", help="Format of the output; default: text."),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Save the comparison; the ending selects the format.")
    ] = None,
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE.png", help="Save a picture of the run that differs most.")
    ] = None,
) -> int:
    """Compare, print or save, and return the exit status: 0 the same, 1 different.

    Raises
    ------
    InputError
        If options exclude each other, or a version or model does not exist.
    """
    chosen = _format(form, out)
    if old is not None and new is None and Path(old).suffix == ".py":
        old, new = (f"{_HEAD}:{old}", old) if Path(old).is_file() else (old, old.partition(":")[2])
    if model is None and new is None and old is not None and names_model(old):
        model, old = old, None
    for path in (out, plot):
        if path is not None:
            check_file(path)
    if paper:
        if old is not None:
            raise InputError(f"--paper compares the current models/ with the paper: leave {old!r} out")
        if structures:
            raise bad_value("--structures", " ".join(structures), "left out with --paper, which compares papers")
        if plot is not None or chosen == "markdown":
            raise InputError("--paper supports neither --plot nor markdown: leave it out; choose text, json or html")
        return _papers(model, chosen, out)
    if plot is not None:
        checked_suffix(plot)
        require_matplotlib()
    diff = diff_versions(_HEAD if old is None else old, WORK if new is None else new, model, structures or ())
    forms = {"json": diff.json_text, "html": lambda: _page(diff), "markdown": lambda: markdown(diff)}
    _deliver(chosen, out, diff.lines(), forms, [f"{part.name}: {part.status.value}" for part in diff.parts])
    if plot is not None:
        _draw(diff, plot)
    return int(diff.differs)


def _draw(diff: Diff, path: Path) -> None:
    """Save the picture of the run with the largest difference, or report that none differs visibly."""
    overlays = [(part.overlay, part.name) for part in diff.parts if part.overlay]
    overlay, name = max(overlays, key=lambda pair: pair[0].size, default=(None, ""))
    figure = overlay.picture(name) if overlay else None
    if figure is None:
        typer.echo(f"{path} is not written: no run of both versions differs visibly", err=True)
        return
    save(figure, path)
    typer.echo(f"saved {path}", err=True)


def _papers(model: str | None, form: str, out: Path | None) -> int:
    """Check the printed equations of papers."""
    from mehvar.reproduction.ledger_page import paper_page
    from mehvar.reproduction.ledger_text import counted, holds, lines
    from mehvar.reproduction.ledgers import paper_ledgers

    with progress("checking the printed equations"):
        ledgers = paper_ledgers(find_tree(Path.cwd()) or installed_tree(), model)
    data = {"schema": 1, "papers": list(ledgers)}
    forms = {
        "json": lambda: json.dumps(data, indent=1, ensure_ascii=False) + "\n",
        "html": lambda: paper_page(ledgers),
    }
    _deliver(form, out, lines(ledgers), forms, [f"{ledger['model']}: {counted(ledger)}" for ledger in ledgers])
    return int(not all(map(holds, ledgers)))


def _deliver(
    form: str, out: Path | None, lines: Iterable[Line], forms: Mapping[str, Callable[[], str]], summary: Sequence[str]
) -> None:
    """Print a report, or save it and print one summary line per model."""
    if form == "text" and out is None:
        with pages():
            print_lines(lines)
        return
    text = plain_text(lines) + "\n" if form == "text" else forms[form]()
    if out is None:
        sys.stdout.write(text)
        return
    write_atomic(out, text)
    for line in (*summary, f"saved {out}"):
        typer.echo(line)


def _page(diff: Diff) -> str:
    from mehvar.comparison.html import html_page  # loads templates

    return html_page(diff)


def _format(form: str | None, out: Path | None) -> str:
    """Return the output format from the option or the file's ending; default: text."""
    if form is not None and form not in FORMATS:
        raise bad_value("--format", form, " or ".join(FORMATS))
    implied = None if out is None else _ENDINGS[checked_ending("--out", out, _ENDINGS)]
    if None not in (form, implied) and form != implied:
        raise bad_value("--format", form, f"left out or {implied}, as {out} ends")
    chosen = form or implied or "text"
    if chosen == "html" and out is None and sys.stdout.isatty():
        raise InputError("--format html needs a file: add --out FILE.html")
    return chosen
