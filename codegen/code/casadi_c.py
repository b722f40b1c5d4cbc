# SPDX-License-Identifier: Apache-2.0
"""CasADi's own C, for tools with its calling convention (acados, casadi.external)."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import casadi as ca

from ..functions.function import FunctionGraph


def casadi_c(model: str, functions: Sequence[FunctionGraph]) -> dict[str, str]:
    """Print the graphs with CasADi, under names that begin with the model's.

    `casadi.external` looks up derivatives by the names `jac_NAME`, `fwd1_NAME`, `adj1_NAME` and `fwd1_adj1_NAME`.
    Those of the right-hand side are included, so that an optimiser gets exact first and second derivatives. The
    Jacobian of `adj1_NAME` is not included, because it would be six to thirty times as long.

    Returns
    -------
    dict of str to str
        MODEL_casadi.c and MODEL_casadi.h.
    """
    name = f"{model}_casadi"
    generator = ca.CodeGenerator(f"{name}.c", {"with_header": True})
    for function in functions:
        graph = _renamed(function.graph, f"{model}_{function.name}")
        generator.add(graph)
        if function.name == "rhs":
            backward = graph.reverse(1)
            for derivative in (graph.jacobian(), graph.forward(1), backward, backward.forward(1)):
                generator.add(derivative)
    with tempfile.TemporaryDirectory() as folder:
        generator.generate(folder + "/")
        return {f"{name}.{kind}": (Path(folder) / f"{name}.{kind}").read_text(encoding="utf-8") for kind in ("c", "h")}


def _renamed(graph: ca.Function, name: str) -> ca.Function:
    arguments: list[Any] = graph.sx_in() if graph.is_a("SXFunction") else graph.mx_in()
    return ca.Function(name, arguments, graph.call(arguments), graph.name_in(), graph.name_out())
