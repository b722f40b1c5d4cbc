# SPDX-License-Identifier: Apache-2.0
"""Headers that a vendor's file includes: prefixed names only, clean in C and C++ beside names of the vendor's own."""

from __future__ import annotations

import importlib.util
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from mehvar.runtime import load
from mehvar.runtime.board.image.build import program, sources
from mehvar.runtime.compiling.compiler import write_sources
from mehvar.runtime.compiling.library import INCLUDE
from tests.tools import needs

PENDULUM = Path(__file__).parents[1] / "pendulum"
LAWS = {"triangle": "path", "slosh": "lyapunov-v1", "satellite": "mrac"}
STRICT = ("-Wall", "-Wextra", "-Wpedantic", "-Wshadow", "-Wconversion", "-Werror", "-fsyntax-only", "-I.", "-I..")
ZIG = importlib.util.find_spec("ziglang") is not None
COMPILERS = [
    *([name, f"-std={standard}"] for name in ("gcc", "clang") for standard in ("c99", "c11")),
    *([name, "-std=c++17"] for name in ("g++", "clang++")),
]
SHORT = ["mask", "real", "scalar", "K", "SPLAT", "LT", "LE", "EQ", "NE", "NOT", "AND", "OR", "XOR", "SELECT", "SELECT0"]
SHORT += ["TRUTH", "NUM"]
VENDORS = {
    "names": "typedef unsigned mask;\nstatic int K, AND, real;\n{0}\n"
    "mask vendor(void);\nmask vendor(void) {{ return (mask)(K + AND + real); }}\n",
    "names after": "{0}\ntypedef unsigned mask;\nstatic int K, AND, real;\n"
    "mask vendor(void);\nmask vendor(void) {{ return (mask)(K + AND + real); }}\n",
    "macros": "".join(f"#define {name} 3\n" for name in SHORT) + "{0}\n",
    "twice": "{0}\n{0}\n",
}


def model_of(folder: Path) -> str:
    return next(folder.glob("*.h")).stem


@pytest.fixture(scope="module", params=LAWS)
def exported(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with all that `mehvar board build` exports for a model: its C, the firmware, every header."""
    folder = tmp_path_factory.mktemp(request.param)
    write_sources(folder, sources(program(load(request.param), LAWS[request.param]), None))
    return folder


def public_headers(folder: Path) -> list[str]:
    """Paths of the headers that a vendor may include."""
    paths = [*folder.glob("*.h"), *(folder / "mehvar").glob("*.h")]
    return sorted(path.relative_to(folder).as_posix() for path in paths)


def compiled(folder: Path, compiler: list[str], text: str, *flags: str) -> subprocess.CompletedProcess[str]:
    """Compile a text that stands in a folder of its own, as a vendor's does."""
    (folder / "vendor").mkdir(exist_ok=True)
    name = "vendor.cc" if "++" in compiler[0] else "vendor.c"
    (folder / "vendor" / name).write_text(text)
    command = [*compiler, *flags, name]
    return subprocess.run(command, cwd=folder / "vendor", capture_output=True, text=True, check=False)


def includes(headers: list[str]) -> str:
    return "".join(f'#include "{header}"\n' for header in headers)


def test_the_public_headers_are_these(exported: Path) -> None:
    ours = ["mehvar/board.h", "mehvar/board_model.h", "mehvar/law.h", "mehvar/real.h", "mehvar/server.h"]
    assert public_headers(exported) == [*ours, f"{model_of(exported)}.h"]


@pytest.mark.parametrize("compiler", [pytest.param(c, marks=needs(c[0])) for c in COMPILERS], ids=" ".join)
@pytest.mark.parametrize("vendor", VENDORS)
@pytest.mark.share(8)
def test_a_vendors_own_names_do_no_harm(exported: Path, compiler: list[str], vendor: str) -> None:
    text = VENDORS[vendor].format(includes(public_headers(exported)))
    for flags in ((), ("-DMEHVAR_FLOAT",), ("-DMEHVAR_LANES=4",)):
        done = compiled(exported, compiler, text, *STRICT, *flags)
        assert done.returncode == 0, done.stderr


def own_text(preprocessed: str) -> list[str]:
    """Lines that come from headers of ours, not from the system's or from the vendor's file itself."""
    lines, ours = [], False
    for line in preprocessed.splitlines():
        marker = re.match(r'# \d+ "([^"]*)"', line)
        if marker:
            ours = marker[1].startswith((".", "mehvar/"))
        elif ours:
            lines.append(line)
    return lines


def names_of(lines: list[str]) -> list[str]:
    """Macros and declared names in text that has been preprocessed with -dD; it must declare and compute nothing."""
    macros = [m[1] for line in lines if (m := re.match(r"#define (\w+)", line))]
    text = "\n".join(line for line in lines if not line.startswith("#"))
    text = re.sub(r"__attribute__\s*\(\(.*?\)\)\)", "", text)
    text = re.sub(r"typedef struct \{[^{}]*\}", "typedef", text)  # names of members cannot clash
    return macros + [name for part in text.split(";") if part.strip() for name in _declared(part.strip())]


def _declared(declaration: str) -> list[str]:
    enumeration = re.fullmatch(r"enum\s*(\w*)\s*\{(.*)\}", declaration, re.DOTALL)
    if enumeration:
        entries = [entry.split("=")[0].strip() for entry in enumeration[2].split(",")]
        return [name for name in (enumeration[1], *entries) if name]
    assert "{" not in declaration, f"a public header declares only: {declaration}"
    function = re.fullmatch(r"[\w\s*]*?(\w+)\s*\([^()]*\)", declaration)
    plain = re.fullmatch(r"(?:typedef|extern)\s[\w\s*]*?(\w+)\s*(?:\[\w*\])?", declaration)
    match = function or plain
    assert match, f"neither function, type, constant nor enumeration: {declaration}"
    return [match[1]]


def wrong_names(folder: Path, headers: list[str], model: str, *flags: str) -> list[str]:
    done = compiled(folder, ["gcc", "-std=c99"], includes(headers), "-E", "-dD", "-I.", "-I..", *flags)
    assert done.returncode == 0, done.stderr
    names = names_of(own_text(done.stdout))
    assert len(names) > 20
    prefixes = ("mv_", "MV_", "MEHVAR_", f"{model}_", f"{model.upper()}_")
    return [name for name in names if not name.startswith(prefixes)]


@pytest.mark.parametrize("flags", [(), ("-DMEHVAR_FLOAT", "-DMEHVAR_LANES=8")], ids=["one lane", "lanes"])
def test_every_public_name_is_prefixed(exported: Path, flags: tuple[str, ...]) -> None:
    """Macros, types, functions, constants and variables, as the compiler sees them."""
    headers = public_headers(exported)
    assert wrong_names(exported, headers, model_of(exported), *flags) == []


@pytest.mark.parametrize(
    ("planted", "name"),
    [
        ("#define AND(a, b) ((a) & (b))", "AND"),
        ("typedef mv_scalar real;", "real"),
        ("enum { MV_ONE, TWO = 2 };", "TWO"),
        ("enum kind { MV_THREE };", "kind"),
        ("void mv_fine(const mv_real *x);\nmv_real board_ms(void);", "board_ms"),
        ("extern const char board_name[];", "board_name"),
        ('#include "mehvar/private/arithmetic.h"', None),
    ],
)
def test_a_planted_name_is_found(exported: Path, tmp_path: Path, planted: str, name: str | None) -> None:
    shutil.copytree(exported, tmp_path / "copy")
    with (tmp_path / "copy" / "mehvar" / "board.h").open("a") as file:
        file.write(planted + "\n")
    model = model_of(exported)
    if name is None:
        with pytest.raises(AssertionError, match="declares only"):
            wrong_names(tmp_path / "copy", public_headers(exported), model)
    else:
        assert wrong_names(tmp_path / "copy", public_headers(exported), model) == [name]


@pytest.mark.share(3)
def test_a_linker_sees_prefixed_symbols_only(exported: Path) -> None:
    model = model_of(exported)
    units = [f"{model}.c", "app.c", "link.c", "server.c"]
    flags = ("-std=c99", "-O1", "-DMEHVAR_FLOAT", "-DMEHVAR_SMALL", "-ffp-contract=off", "-I.")
    subprocess.run(["gcc", *flags, "-c", *units], cwd=exported, check=True)
    objects = [Path(unit).with_suffix(".o").name for unit in units]
    command = ["nm", "-g", "--defined-only", "-P", *objects]
    done = subprocess.run(command, cwd=exported, capture_output=True, text=True, check=True)
    symbols = [line.split()[0] for line in done.stdout.splitlines() if not line.endswith(":")]
    assert len(symbols) > 20
    assert [name for name in symbols if not name.startswith((f"{model}_", "mv_"))] == []


MATH_H = """\
#define INFINITY ((float)(1e300 * 1e300))
#define NAN (INFINITY * 0.0f)
#define BOTH(name) double name(double); float name##f(float);
BOTH(fabs) BOTH(sqrt) BOTH(sinh) BOTH(cosh) BOTH(tanh) BOTH(asinh) BOTH(acosh) BOTH(atanh)
BOTH(expm1) BOTH(log1p) BOTH(erf)
double copysign(double, double), fmod(double, double);
float copysignf(float, float), fmodf(float, float);
"""


@needs("clang")
@pytest.mark.parametrize("flags", [(), ("-DMEHVAR_FLOAT",)], ids=["double", "float"])
def test_generated_c_needs_no_gnu_c_at_one_lane(exported: Path, tmp_path: Path, flags: tuple[str, ...]) -> None:
    """clang as Microsoft's compiler, which has no GNU C; of its library math.h is all that is needed."""
    (tmp_path / "math.h").write_text(MATH_H)
    model = model_of(exported)
    command = ["clang", "--target=x86_64-pc-windows-msvc", "-std=c11", *STRICT, "-Wno-shadow", f"-I{tmp_path}", *flags]
    done = subprocess.run([*command, f"{model}.c"], cwd=exported, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    macros = subprocess.run([*command, "-E", "-dM", f"{model}.c"], cwd=exported, capture_output=True, text=True)
    assert "__GNUC__" not in macros.stdout


@pytest.mark.skipif(not ZIG, reason="no ziglang: pip install mehvar[board]")
@pytest.mark.share(3)
def test_generated_c_compiles_for_windows(exported: Path) -> None:
    model = model_of(exported)
    flags = ["-target", "x86_64-windows-gnu", "-std=c99", "-Wpedantic", "-Werror", "-I.", "-c"]
    command = [sys.executable, "-m", "ziglang", "cc", *flags, f"{model}.c", "-o", "windows.o"]
    done = subprocess.run(command, cwd=exported, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_a_hand_written_model_keeps_the_rule(tmp_path: Path) -> None:
    shutil.copytree(INCLUDE, tmp_path, dirs_exist_ok=True)
    shutil.copyfile(PENDULUM / "pendulum.h", tmp_path / "pendulum.h")
    assert wrong_names(tmp_path, ["pendulum.h"], "pendulum") == []
