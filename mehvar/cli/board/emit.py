# SPDX-License-Identifier: Apache-2.0
"""`mehvar board emit`: a law as a package for another project's build system or framework.

All packages have the same folder `src` and the files of one build system. Settings that affect rounding are in the
sources, because not every build system supports flags per library. Headers contain no such settings, which would
change the code of the including project.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mehvar.base.errors import bad_value, unknown_name
from mehvar.cli.board.loop import Inline, Law, Tunable, compiled, tunable_of
from mehvar.package.files import FRAMEWORKS, KINDS, package
from mehvar.package.law import law_inputs
from mehvar.runtime.board.image.build import Program, program
from mehvar.runtime.compiling.compiler import write_sources
from mehvar.runtime.files import check_folder, filling
from mehvar.runtime.units import read_value
from mehvar.settings import ModelName, Scenario, read_settings


def command(
    model: ModelName,
    controller: Law,
    kind: Annotated[str, typer.Option("--for", metavar="KIND", help=f"{', '.join(KINDS)}.")],
    out: Annotated[Path, typer.Option(metavar="DIR", help="The folder to write.")],
    scenario: Scenario = None,
    within: Annotated[
        list[str] | None,
        typer.Option(
            "--range", metavar="NAME=LEAST:MOST", help="Range of a measurement or reference; repeat as needed."
        ),
    ] = None,
    link: Annotated[bool, typer.Option("--link", help="Add the serial line to `mehvar board run`.")] = False,
    inline: Inline = False,
    tunable: Tunable = None,
) -> None:
    """Write a law as a package for a build system or framework: C functions on a state that the caller owns."""
    if kind not in KINDS:
        raise unknown_name("build system", kind, KINDS, "--for")
    if link and kind in FRAMEWORKS:
        raise bad_value("link", True, f"left out with --for {kind}: the framework carries the messages", "--link")
    if inline and not link:
        raise bad_value("inline-parameters", True, "given with --link", "--inline-parameters")
    if within and link:
        raise bad_value("range", within[0], "left out with --link: the host checks the numbers", "--range")
    maker = f"mehvar board emit {model} {controller}"
    check_folder(out, maker, ["README.md", "src"])
    loaded = compiled(model)
    firmware = program(loaded, controller, scenario, tunable=tunable_of(inline, tunable))
    ranges = _ranges(within, firmware)
    with filling(out, maker) as folder:
        write_sources(folder, package(firmware, kind, link, ranges))
    typer.echo(f"wrote {out}: {', '.join(sorted(path.name for path in out.iterdir() if path.name[0] != '.'))}")


def _ranges(texts: list[str] | None, firmware: Program) -> dict[str, tuple[float, float]]:
    """Return allowed ranges by quantity, from texts such as `roll=-70deg:70deg`."""
    units = {q.name: q.unit for q in law_inputs(firmware)} if texts else {}
    ranges = {}
    for name, text in read_settings(texts, "--range").items():
        if name not in units:
            raise unknown_name("input of the law", name, units, "--range")
        bounds = [read_value(bound, units[name], name, "--range") for bound in text.split(":")]
        least, most = bounds if len(bounds) == 2 else ("", "")
        if isinstance(least, str) or isinstance(most, str):
            raise bad_value("range", f"{name}={text}", "NAME=LEAST:MOST, such as roll=-70deg:70deg", "--range")
        ranges[name] = (float(least), float(most))
    return ranges
