# SPDX-License-Identifier: Apache-2.0
"""Generated functions in CasADi's own C, adapted to mehvar's calling convention."""

from __future__ import annotations

import ctypes
from collections.abc import Iterable
from dataclasses import replace

from mehvar.base.manifest import Function, Manifest
from mehvar.base.names import identifier

from ..compiling.library import load_library
from .derived import folder_with
from .functions import BackendName, CBackend, Real
from .generated import generated_text


def casadi_manifest(manifest: Manifest) -> Manifest:
    """Return a manifest of the functions in CasADi's file, without split functions.

    Raises
    ------
    InputError
        If the file is missing and cannot be made.
    """
    file = f"{manifest.model}_casadi.c"
    folder_with(manifest, file)
    functions = {name: replace(f, file=file) for name, f in manifest.whole.functions.items()}
    return replace(manifest, functions=functions)


class CasadiBackend(CBackend):
    """Backend for CasADi's C: one library with all functions and Jacobians, in double and one lane.

    It uses elementary functions of the C library, whose `fmin` and `fmax` ignore NaN.

    Parameters
    ----------
    manifest : Manifest
        Result of `casadi_manifest`.
    """

    name: BackendName = "casadi"

    def prepare(self) -> None:
        """Compile or load the integrators and the model."""
        self._native_map()
        self._library(self._manifest.functions["rhs"].file)

    def address(self, name: str, real: Real = "double") -> int:
        """Return a C function's address for the native loop, on doubles."""
        library = self._library(self._manifest.functions[name].file, real)
        return ctypes.cast(getattr(library, f"direct_{identifier(name)}"), ctypes.c_void_p).value or 0

    def _build(self, file: str, real: Real) -> ctypes.CDLL:
        assert real == "double"
        calls = _calls_text(self._manifest.model, file, self._manifest.functions.values())
        # Long C that serves comparison only: compile time matters more than run time. Slosh takes 6 s, and 23 with -O1.
        sources = {file: generated_text(self._manifest, file), "calls.c": calls}
        return load_library(identifier(file.removesuffix(".c")), sources, ["calls.c"], ["-O0"])


def _calls_text(model: str, file: str, functions: Iterable[Function]) -> str:
    """Return C code that adapts CasADi's functions to mehvar's two signatures, without work space."""
    lines = [f'#include "{file}"', ""]
    for function in functions:
        name, symbol = identifier(function.name), f"{identifier(model)}_{identifier(function.name)}"
        arguments = [f"a{k}" for k in range(len(function.arguments))]
        results = [f"r{k}" for k in range(len(function.results))]
        signature = [f"const double *{a}" for a in arguments] + [f"double *{r}" for r in results]
        lines += [
            f"void call_{name}(const double *const *a, double *const *r)",
            f"{{ {symbol}((const double **)a, (double **)r, 0, 0, 0); }}",
            f"void direct_{name}({', '.join(signature)})",
            "{",
            f"    const double *a[] = {{{', '.join(arguments)}}};",
            f"    double *r[] = {{{', '.join(results)}}};",
            f"    {symbol}(a, r, 0, 0, 0);",
            "}",
        ]
    return "\n".join(lines) + "\n"
