# SPDX-License-Identifier: Apache-2.0
"""`mehvar require`: verdicts on requirements from a store or a campaign."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mehvar.base.errors import InputError, bad_value
from mehvar.report.verdicts import Verdicts, require
from mehvar.runtime.batch.evaluation.requirements import checked_confidence
from mehvar.runtime.files import check_file, checked_ending, write_atomic
from mehvar.settings import AsJson, read_settings
from mehvar.terminal import print_json, progress

_USAGE = 'NAME=REQUIREMENT, as in "pointing=quantile(0.997, PEAK) < 0.02 deg"'


def command(
    path: Annotated[
        Path, typer.Argument(metavar="STORE|CAMPAIGN.toml", help="A batch, or a campaign to run until decided.")
    ],
    texts: Annotated[
        list[str] | None,
        typer.Option(
            "--that",
            metavar="NAME=REQUIREMENT",
            help='Requirement, as in "pointing=quantile(0.997, PEAK) < 0.02 deg"; repeat as needed.',
        ),
    ] = None,
    confidence: Annotated[
        float | None, typer.Option(metavar="C", help="Confidence of each bound; default: 0.95.")
    ] = None,
    rare: Annotated[
        bool, typer.Option("--rare", help="Search for rare failures by splitting; needs a campaign.")
    ] = False,
    out: Annotated[Path | None, typer.Option(metavar="STORE.zarr", help="The store of a campaign.")] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Continue the store.")] = False,
    page: Annotated[Path | None, typer.Option(metavar="FILE.html", help="Save a page for a review.")] = None,
    as_json: AsJson = False,
) -> int:
    """Decide requirements and print the verdicts; return 0 if all hold, else 1.

    Raises
    ------
    InputError
        If there is no requirement, a requirement cannot be read, or the store or campaign is unusable.
    """
    checked_confidence(confidence, "--confidence")
    if page is not None:
        checked_ending("page", page, [".html"], "--page")
        check_file(page)
    requirements = _requirements(texts) or None
    if path.suffix == ".toml":
        verdicts = _run(path, requirements, confidence, rare, out, resume)
    elif rare:
        raise InputError(f"--rare draws new runs, and {path} is a finished batch: give a campaign file")
    elif out is not None or resume:
        raise InputError("--out and --resume need a campaign file: a store has its runs; leave them out")
    else:
        verdicts = require(path, requirements, confidence=confidence)
    if as_json:
        print_json(verdicts.facts())
    else:
        typer.echo("\n".join(verdicts.lines()))
    if page is not None:
        write_atomic(page, verdicts.page().encode())
        typer.echo(f"saved {page}", err=as_json)
    return 0 if verdicts.hold else 1


def _requirements(texts: list[str] | None) -> dict[str, str]:
    """Return requirements by name; refuse one without a name, and a name that occurs twice."""
    requirements = read_settings(texts, "--that", _USAGE)
    for name, text in requirements.items():
        if not name.isidentifier():  # a comparison has an equals sign too
            raise bad_value("--that", f"{name}={text}", _USAGE)
    return requirements


def _run(
    path: Path,
    requirements: dict[str, str] | None,
    confidence: float | None,
    rare: bool,
    out: Path | None,
    resume: bool,
) -> Verdicts:
    """Run a campaign until its requirements are decided."""
    if rare and (out is not None or resume):
        raise InputError("--rare does not store runs: leave out --out and --resume")
    store = {} if rare else {"out": out, "resume": resume}
    with progress(f"{path} seeks failures" if rare else f"{path} until decided") as advance:

        def report(runs: int, total: int, failed: int | None = None) -> None:
            advance(runs, total, f"{runs} runs" if failed is None else f"{runs} runs, {failed} not done")

        return require(path, requirements, confidence=confidence, rare=rare, report=report, **store)
