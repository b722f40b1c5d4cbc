# SPDX-License-Identifier: Apache-2.0
"""Files of a package: sources in `src`, and build files from templates."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.metadata import version

from mehvar.base.names import identifier
from mehvar.codegen.templates import text_environment
from mehvar.runtime.board.image.build import Program, sources

from .law import TEMPLATES, law_facts, law_files

KINDS = {
    "cmake": "`add_subdirectory` of this folder, then link with `{name}`.",
    "zephyr": "A module: name this folder in `ZEPHYR_EXTRA_MODULES` and set `CONFIG_{NAME}=y`.",
    "platformio": "A library: put this folder into `lib` of a project.",
    "arduino": "A library: put this folder into `libraries` of the sketchbook, and include its header.",
    "cfs": "An app of cFS: put this folder into `apps` and name it in `targets.cmake`; the parameters are its table.",
    "fprime": "A component of F Prime: put this folder into a deployment and `add_fprime_subdirectory` it.",
    "stm32cube": "A CMSIS pack's folder: add `src` to sources and include paths of a project, or install the pack.",
}
"""Kinds of packages with descriptions; each has a folder of templates of its name."""
FRAMEWORKS = ("cfs", "fprime")
"""Kinds of packages for frameworks, which call the law themselves."""
_NUMBERS = """\
/* Numbers of this package: the type of mv_real. The code needs nothing of a C library but memcpy and memset,
 * where a compiler puts them. */
#define MEHVAR_FLOAT
#define MEHVAR_SMALL
#define MEHVAR_NO_LIBM

"""
_ARITHMETIC = """\
/* Arithmetic of this file; a compiler without GNU C must be told not to contract a*b + c. */
#if defined __GNUC__ && !defined __clang__
#pragma GCC optimize("fp-contract=off", "no-math-errno", "no-tree-loop-distribute-patterns")
#elif defined __clang__
#pragma STDC FP_CONTRACT OFF
#endif

"""
_NOT_IN_A_PACKAGE = ("boards/", "main.c")
"""Files that are not in a package, because each project supplies them: functions of mehvar/board.h and a main loop."""


def package(
    firmware: Program, kind: str, link: bool = False, ranges: Mapping[str, tuple[float, float]] | None = None
) -> dict[str, str]:
    """Return the files of a package by path.

    Parameters
    ----------
    link : bool
        True for a law with a serial link to mehvar, False for the law as functions.
    ranges : mapping of str to (float, float), optional
        Allowed values of measurements and references of the law as functions.
    """
    facts = law_facts(firmware, ranges or {}) | {"version": version("mehvar"), "kind": kind, "link": link}
    if link:
        texts = {name: text for name, text in sources(firmware, None).items() if not name.startswith(_NOT_IN_A_PACKAGE)}
        facts |= {"name": f"{facts['name']}_link", "NAME": f"{facts['NAME']}_LINK"}
        headers = ["mehvar/server.h", "mehvar/board.h", "mehvar/board_model.h"]
    else:
        texts = law_files(firmware, ranges or {}, facts["version"])
        headers = [f"{facts['name']}.h"]
    texts["mehvar/real.h"] = texts["mehvar/real.h"].replace(
        "#ifndef MEHVAR_REAL_H", f"{_NUMBERS}#ifndef MEHVAR_REAL_H", 1
    )
    units = sorted(name for name in texts if name.endswith(".c"))
    texts |= {name: _ARITHMETIC + texts[name] for name in units}
    title = f"{firmware.model.name} under {firmware.law.name}"
    facts |= {"units": units, "headers": headers, "title": title, "use": KINDS[kind].format_map(facts)}
    return {f"src/{path}": text for path, text in texts.items()} | _rendered(kind, facts)


def _rendered(kind: str, facts: Mapping[str, object]) -> dict[str, str]:
    """Return the files from a folder of templates, and the package's README."""
    environment = text_environment(TEMPLATES)
    environment.filters["identifier"] = identifier
    names = ["README.md.j2", *(name for name in environment.list_templates() if name.startswith(f"{kind}/"))]
    place = {name: name.removeprefix(f"{kind}/").removesuffix(".j2") for name in names}
    return {
        place[name].replace("NAME", str(facts["name"])).replace("CAMEL", str(facts["Camel"])): environment.get_template(
            name
        ).render(facts)
        for name in names
    }
