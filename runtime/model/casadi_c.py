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


_CALL = """
#include <stdlib.h>
#include <string.h>

typedef int (*function)(const double **, double **, casadi_int *, double *, int);
typedef int (*sizes)(casadi_int *, casadi_int *, casadi_int *, casadi_int *);

static void call(function f, sizes work, const double *const *a, int arguments, double *const *r, int results)
{
    casadi_int n_arg, n_res, n_iw, n_w;
    work(&n_arg, &n_res, &n_iw, &n_w);
    const double *arg[n_arg];
    double *res[n_res], *w = malloc((n_w + 1) * sizeof *w);
    casadi_int iw[n_iw + 1];
    if (!w)
        abort();
    memcpy(arg, a, arguments * sizeof *a);
    memcpy(res, r, results * sizeof *r);
    f(arg, res, iw, w, 0);
    free(w);
}
"""


def _calls_text(model: str, file: str, functions: Iterable[Function]) -> str:
    """Return C code that adapts CasADi's functions, which take work space, to mehvar's two signatures."""
    lines = [f'#include "{file}"', _CALL]
    for function in functions:
        name, symbol = identifier(function.name), f"{identifier(model)}_{identifier(function.name)}"
        arguments = [f"a{k}" for k in range(len(function.arguments))]
        results = [f"r{k}" for k in range(len(function.results))]
        signature = [f"const double *{a}" for a in arguments] + [f"double *{r}" for r in results]
        lines += [
            f"void call_{name}(const double *const *a, double *const *r)",
            f"{{ call({symbol}, {symbol}_work, a, {len(arguments)}, r, {len(results)}); }}",
            f"void direct_{name}({', '.join(signature)})",
            "{",
            f"    const double *a[] = {{{', '.join(arguments)}}};",
            f"    double *r[] = {{{', '.join(results)}}};",
            f"    call_{name}(a, r);",
            "}",
        ]
    return "\n".join(lines) + "\n"
