# SPDX-License-Identifier: Apache-2.0
"""`mehvar generate`: derivation of models and generation of their files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated

import typer

from mehvar.base.errors import InputError, bad_value, unknown_name
from mehvar.base.manifest import FILE, read_manifest
from mehvar.codegen import generate as generation
from mehvar.codegen.generate import Report, Tree, find_tree, installed_tree
from mehvar.runtime.files import check_folder
from mehvar.settings import read_settings
from mehvar.terminal import progress


def command(
    models: Annotated[list[str] | None, typer.Argument(metavar="MODEL...", help="Models; default: all.")] = None,
    check: Annotated[bool, typer.Option("--check", help="Change nothing; exit 1 if files are stale.")] = False,
    structure: Annotated[
        list[str] | None, typer.Option(metavar="NAME=VALUE", help="Derive a structural variant; needs --out.")
    ] = None,
    out: Annotated[Path | None, typer.Option(metavar="DIR", help="Write here instead of generated/MODEL.")] = None,
    emit: Annotated[str | None, typer.Option(metavar="casadi", help="Also write CasADi's own C.")] = None,
) -> int:
    """Check the generated files or rewrite them; return the exit status."""
    if check:
        for flag, value in (("--structure", structure), ("--out", out), ("--emit", emit)):
            if value is not None:
                raise bad_value(
                    flag, value, "left out with --check: it checks the files that generate writes without options"
                )
        return check_models(models or [])
    generate_models(models or [], read_settings(structure, "--structure"), out, emit)
    return 0


def check_models(models: Sequence[str]) -> int:
    """Print each stale file, the reason, and the command that updates it; return the exit status."""
    tree = find_tree(Path.cwd()) or installed_tree()
    orphans = {} if models else tree.orphans
    reports = [generation.check(tree, model) for model in _names(tree, models)]
    reports += [Report(name, reasons=(missing,)) for name, missing in orphans.items()]
    for report in reports:
        _explain(report)
    return int(any(report.stale for report in reports))


def generate_models(models: Sequence[str], structure: Mapping[str, str], out: Path | None, emit: str | None) -> None:
    """Derive stale models and report the files written.

    Raises
    ------
    InputError
        If options exclude each other.
    """
    tree = find_tree(Path.cwd())
    if tree is None and out is None:
        raise InputError("no project (models/ beside generated/) at or above this folder: add --out DIR")
    tree = tree or installed_tree()
    names = _names(tree, models)
    if not models and tree.orphans:
        raise InputError(
            f"{next(iter(tree.orphans.values()))}: restore this file or folder, or remove the other files of the model"
        )
    if structure and out is None:
        raise InputError("--structure derives a variant, which needs a folder: add --out DIR")
    if out is not None and len(names) != 1:
        raise InputError(f"--out takes one model, not {len(names)}: {', '.join(names)}")
    if emit not in (None, "casadi"):
        raise bad_value("--emit", emit, "casadi")
    if out is not None:
        check_folder(out)
        _check_own(out, names[0])
    for model in names:
        with progress(f"deriving {model}"):
            report = generation.generate(tree, model, out, structure, emit == "casadi")
        where = out or Path("generated") / model
        typer.echo(f"{model}: {'wrote ' + str(where) if report.written else 'up to date'}")
        if report.written:
            _note_hidden(out or tree.root / "generated" / model)


def _check_own(out: Path, model: str) -> None:
    """Refuse a folder of another model, because its files would remain beside the new files."""
    if (out / FILE).is_file() and (there := read_manifest(out).model) != model:
        raise bad_value("out", str(out), f"another folder: this one has the model {there}", "--out")


def _note_hidden(folder: Path) -> None:
    """Print the names of result variables that cannot be attributes of an xarray dataset."""
    from mehvar.runtime.run.results import hidden_names

    for name in hidden_names(read_manifest(folder)):
        typer.echo(f"note: {name} is also an attribute of every dataset: write run[{name!r}], not run.{name}", err=True)


def _names(tree: Tree, models: Sequence[str]) -> tuple[str, ...]:
    for model in models:
        if model not in tree.models:
            if model in tree.orphans:
                raise InputError(tree.orphans[model])
            raise unknown_name("model", model, tree.models, str(tree.root / "models"))
    return tuple(models) or tree.models


def _explain(report: Report) -> None:
    if not report.stale:
        typer.echo(f"{report.model}: up to date")
        return
    typer.echo(f"{report.model}: stale, because {'; '.join(report.reasons)}")
    for name in report.written:
        typer.echo(f"  generated/{report.model}/{name}")
    if report.written:
        typer.echo(f"  update it with: mehvar generate {report.model}")
