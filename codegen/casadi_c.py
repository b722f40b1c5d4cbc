# SPDX-License-Identifier: Apache-2.0
"""CasADi's own C, for tools that expect its calling convention (acados, casadi.external)."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path

import casadi as ca

from codegen.functions import GeneratedFunction


def casadi_c(model: str, functions: Sequence[GeneratedFunction]) -> dict[str, str]:
    """Let CasADi print the same graphs.

    Returns
    -------
    dict of str to str
        MODEL_casadi.c and MODEL_casadi.h.
    """
    name = f"{model}_casadi"
    generator = ca.CodeGenerator(f"{name}.c", {"with_header": True, "casadi_real": "double", "casadi_int": "int"})
    for function in functions:
        generator.add(function.graph)
    with tempfile.TemporaryDirectory() as folder:
        generator.generate(folder + "/")
        return {f"{name}.{kind}": (Path(folder) / f"{name}.{kind}").read_text(encoding="utf-8") for kind in ("c", "h")}
