# SPDX-License-Identifier: Apache-2.0
"""`mehvar export fmu`: a functional mock-up unit."""

from __future__ import annotations

from typing import Annotated, cast

import typer

from mehvar.fmu.description import Interface, Version
from mehvar.fmu.export import export_fmu
from mehvar.settings import ModelName


def command(
    model: ModelName,
    out: Annotated[str, typer.Option("--out", metavar="FILE.fmu", help="The file to write.")],
    controller: Annotated[
        str | None, typer.Option(metavar="LAW", help="The law of a closed loop; default: the plant without a law.")
    ] = None,
    scenario: Annotated[str | None, typer.Option(metavar="NAME", help="Scenario of the start values.")] = None,
    fmi: Annotated[str, typer.Option("--fmi", metavar="2.0|3.0", help="Version of the standard.")] = "2.0",
    kind: Annotated[str, typer.Option("--kind", metavar="cs|me", help="Co-simulation or model exchange.")] = "cs",
) -> None:
    """Write sources, a binary for this platform and modelDescription.xml into one file."""
    export_fmu(model, out, controller=controller, scenario=scenario, fmi=cast(Version, fmi), kind=cast(Interface, kind))
    typer.echo(f"{out}: {model}, FMI {fmi}, {'co-simulation' if kind == 'cs' else 'model exchange'}")
