# SPDX-License-Identifier: Apache-2.0
"""The C arithmetic below every generated function: accuracy, special values, and the same bits in every lane."""

from __future__ import annotations

import ctypes
import importlib.util
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest

from mehvar.runtime.compiling.compiler import require_compiler
from mehvar.runtime.compiling.library import FLAGS, INCLUDE

Array = np.ndarray[Any, Any]
DTYPES = (np.float64, np.float32)
WARNINGS = ["-Wall", "-Wextra", "-Wconversion", "-Wdouble-promotion", "-Wno-psabi", "-Werror"]
ZIG = (sys.executable, "-m", "ziglang", "cc") if importlib.util.find_spec("ziglang") else None

OWN_UNARY = ["sqrt", "fabs", "floor", "ceil", "sign", "sin", "cos", "tan", "asin", "acos", "atan", "exp", "log"]
OWN_BINARY = ["copysign", "min", "max", "hypot", "atan2", "pow"]
LIBM_UNARY = ["sinh", "cosh", "tanh", "asinh", "acosh", "atanh", "expm1", "log1p", "erf"]
OWN = {
    **{name: f"mv_{name}(a)" for name in OWN_UNARY},
    **{name: f"mv_{name}(a, b)" for name in OWN_BINARY},
    "sine_of_sincos": "({ real s, c; mv_sincos(a, &s, &c); s; })",
    "cosine_of_sincos": "({ real s, c; mv_sincos(a, &s, &c); c; })",
    "lt": "NUM(LT(a, b))",
    "le": "NUM(LE(a, b))",
    "eq": "NUM(EQ(a, b))",
    "ne": "NUM(NE(a, b))",
    "lt_constant": "NUM(LT(K(0.5), a))",
    "not": "NUM(NOT(LT(a, b)))",
    "and": "NUM(AND(LT(a, b), LT(K(0.0), a)))",
    "or": "NUM(OR(LT(a, b), LT(K(0.0), a)))",
    "truth": "NUM(TRUTH(a))",
    "select": "SELECT(LT(a, b), a, K(2.0) * b)",
    "select0": "SELECT0(LT(a, b), a)",
    "splat": "SELECT(TRUTH(a), SPLAT(-0.0), SPLAT(0.1))",
    "infix": "(K(1.0) - a) * K(0.1) + -b / K(3.0)",
}
ALL = {**OWN, **{name: f"mv_{name}(a)" for name in LIBM_UNARY}, "fmod": "mv_fmod(a, b)"}

# largest error in units in the last place
ACCURACY = {
    "sqrt": 0.5, "hypot": 1.3, "sin": 0.8, "cos": 0.8, "tan": 1.4, "asin": 1.15, "acos": 1.15, "atan": 1.4,
    "atan2": 1.6, "exp": 1.0, "log": 0.9, "pow": 1.4, **dict.fromkeys(LIBM_UNARY, 4.0),
}  # fmt: skip
SPECIAL = [0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 2.0**24 + 2, 2.0**53 - 1, 1e30, np.inf]
SPECIAL = [*SPECIAL, *(-x for x in SPECIAL), np.nan]


@dataclass(frozen=True)
class Arithmetic:
    """The functions of `ALL`, compiled for one type and number of lanes."""

    library: ctypes.CDLL
    lanes: int
    dtype: Any

    def __call__(self, name: str, x: Any, y: Any = 0.0) -> Array:
        a, b = np.broadcast_arrays(np.asarray(x, self.dtype), np.asarray(y, self.dtype))
        blocks = -(-a.size // self.lanes)
        arrays = [_aligned(blocks * self.lanes, self.dtype) for _ in range(3)]
        arrays[0][: a.size], arrays[1][: a.size] = a.ravel(), b.ravel()
        run = self.library[f"run_{name}"]
        run(ctypes.c_long(blocks), *(ctypes.c_void_p(array.ctypes.data) for array in arrays))
        return arrays[2][: a.size].reshape(a.shape)


def _aligned(n: int, dtype: Any) -> Array:
    buffer = np.zeros(n * np.dtype(dtype).itemsize + 64, np.uint8)
    start = -buffer.ctypes.data % 64
    values: Array = buffer[start : start + n * np.dtype(dtype).itemsize].view(dtype)
    return values


def _harness(expressions: dict[str, str]) -> str:
    return '#include "mehvar/private/arithmetic.h"\n' + "".join(
        f"void run_{name}(long n, const real *x, const real *y, real *r);\n"
        f"void run_{name}(long n, const real *x, const real *y, real *r)\n"
        f"{{ for (long i = 0; i < n; i++) {{ const real a = x[i], b = y[i]; (void)b; r[i] = {text}; }} }}\n"
        for name, text in expressions.items()
    )


def _flags(dtype: Any, lanes: int) -> list[str]:
    kind = ["-DMEHVAR_FLOAT"] if dtype is np.float32 else []
    return [*FLAGS, *WARNINGS, f"-I{INCLUDE}", f"-DMEHVAR_LANES={lanes}", *kind]


def _run(command: list[str], folder: Path) -> None:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def _compile(folder: Path, dtype: Any, lanes: int, flags: list[str], zig: bool = False) -> Arithmetic:
    (folder / "harness.c").write_text(_harness(ALL))
    compiler = require_compiler()
    flags = [*_flags(dtype, lanes), *flags]
    if zig:
        assert ZIG is not None
        _run([*ZIG, *flags, "-fno-sanitize=undefined", "-c", "harness.c", "-o", "harness.o"], folder)
        _run([*compiler.command, "-shared", "harness.o", "-o", "harness.so", "-lm"], folder)
    else:
        _run([*compiler.command, *flags, *compiler.flags, "harness.c", "-o", "harness.so", "-lm"], folder)
    return Arithmetic(ctypes.CDLL(str(folder / "harness.so")), lanes, dtype)


@pytest.fixture(scope="module", params=DTYPES, ids=["double", "float"])
def scalar(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Arithmetic:
    """One lane, the reference for all other builds."""
    return _compile(tmp_path_factory.mktemp("math"), request.param, 1, ["-O2"])


def _samples(name: str, dtype: Any) -> tuple[Array, Array]:
    """Random arguments over the range where a function is accurate, with the places where it is hard."""
    rng = np.random.default_rng(7)
    n, single = 500, dtype is np.float32
    tiny, most, exponent = (1e-37, 1e37, 87.0) if single else (1e-300, 1e300, 708.0)

    def spread(low: float, high: float) -> Array:
        return np.exp(rng.uniform(np.log(low), np.log(high), n)) * rng.choice([-1, 1], n)

    y = np.concatenate([rng.normal(size=n), spread(1e-9, 1e9), rng.normal(size=n)])
    if name in ("sin", "cos", "tan"):
        turns = rng.integers(-60000, 60000, n) * (np.pi / 2)
        x = [rng.uniform(-7, 7, n), rng.uniform(-1e5, 1e5, n), spread(tiny, 1e5), turns]
        x += [np.array([45.553093477052, 252.89820861816406, 102900.0])]  # closest to a multiple of pi/2
    elif name in ("asin", "acos", "atanh"):
        x = [rng.uniform(-1, 1, n), rng.uniform(0.45, 0.65, n), spread(tiny, 1), 1 - np.abs(spread(1e-6, 0.5))]
    elif name in ("exp", "sinh", "cosh", "expm1"):
        deep = rng.uniform(-exponent - 35 if single else -exponent - 36, -exponent, n)  # subnormal results
        x = [rng.uniform(-exponent, exponent, n), rng.uniform(-1, 1, n), spread(tiny, 1)]
        x += [deep] if name == "exp" else []
    elif name in ("log", "sqrt"):
        x = [np.abs(spread(tiny, most)), rng.uniform(0.4, 2.2, n), np.abs(spread(tiny * 1e-6, tiny))]
    elif name == "acosh":
        x = [1 + np.abs(spread(1e-6, most))]
    elif name == "log1p":
        x = [spread(tiny, 0.9), np.abs(spread(tiny, most))]
    elif name == "pow":
        base = np.abs(spread(1e-3, 1e3))
        x = [base, np.abs(spread(tiny, most)), 1 + rng.uniform(-0.1, 0.1, n)]
        steep = rng.uniform(-0.95, 0.95, n) * exponent / np.log(base.astype(dtype).astype(float))
        y = np.concatenate([steep, rng.uniform(-0.99, 0.99, n), rng.uniform(-500, 500, n)])
    elif name == "atan2":
        x = [rng.normal(size=n), spread(1e-9, 1e9), rng.normal(size=n)]
        y[2 * n :] = x[2] * (1 + 1e-3 * rng.normal(size=n))
    else:
        x = [rng.normal(size=n), spread(1e-9, 1e9), rng.uniform(-7, 7, n)]
    a, b = np.concatenate(x), np.resize(y, sum(map(len, x)))
    return a.astype(dtype), b.astype(dtype)


def _ulps(value: float, exact: Any, dtype: Any) -> float:
    """Distance of a value from the exact one in units in the last place of the exact one."""
    if exact == 0:
        return 0.0 if value == 0 else np.inf
    info = np.finfo(dtype)
    place = max(mpmath.frexp(exact)[1] - 1, int(info.minexp)) - int(info.nmant)
    return float(abs(mpmath.mpf(value) - exact) * mpmath.mpf(2) ** -place)


@pytest.mark.parametrize("name", ACCURACY)
def test_accuracy(scalar: Arithmetic, name: str) -> None:
    exact = getattr(mpmath, {"pow": "power"}.get(name, name))
    x, y = _samples(name, scalar.dtype)
    arguments = [x, y] if name in OWN_BINARY else [x]
    got = scalar(name, *arguments)
    with mpmath.workdps(50):
        errors = [
            _ulps(float(g), exact(*(mpmath.mpf(float(v)) for v in values)), scalar.dtype)
            for g, *values in zip(got, *arguments, strict=True)
        ]
    worst = int(np.argmax(errors))
    assert errors[worst] <= ACCURACY[name], [float(a[worst]) for a in arguments]


def _bits(values: Array) -> Array:
    """Bit patterns, with one pattern for every NaN."""
    return np.where(np.isnan(values), values.dtype.type(np.nan), values).view(f"u{values.itemsize}")


BUILDS: dict[str, tuple[int, list[str], bool]] = {
    "4 lanes -O3": (4, ["-O3"], False),
    "8 lanes": (8, ["-O2"], False),
    "16 lanes -O1": (16, ["-O1"], False),
    "8 lanes for this machine": (8, ["-O3", "-march=native"], False),
    **({"clang": (1, ["-O2"], True), "clang 8 lanes": (8, ["-O3"], True)} if ZIG else {}),
    **({"without GNU C": (1, ["-O2", "-U__GNUC__", "-Wno-literal-range"], True)} if ZIG else {}),
}


@pytest.mark.parametrize("build", BUILDS)
@pytest.mark.share(6)
def test_every_build_gives_the_same_bits(scalar: Arithmetic, build: str, tmp_path: Path) -> None:
    other = _compile(tmp_path, scalar.dtype, *BUILDS[build])
    grid = [v.ravel() for v in np.meshgrid(SPECIAL, SPECIAL)]
    for name in ALL:
        x, y = (np.concatenate([a, b]) for a, b in zip(_samples(name, scalar.dtype), grid, strict=True))
        same = _bits(scalar(name, x, y)) == _bits(other(name, x, y))
        assert same.all(), (name, x[~same][:3], y[~same][:3])


def _assert_identical(got: Array, expected: Array) -> None:
    expected = expected.astype(got.dtype)
    assert (_bits(got) == _bits(expected)).all(), (got, expected)


UNARY_CASES = {
    "sin": [(-0.0, -0.0), (np.inf, np.nan), (1e30, 0.0), (-1e30, -0.0)],
    "cos": [(0.0, 1.0), (-np.inf, np.nan), (1e30, 1.0), (-1e30, 1.0)],
    "tan": [(-0.0, -0.0), (np.inf, np.nan), (1e30, 0.0)],
    "asin": [(-0.0, -0.0), (1.0, np.pi / 2), (-1.0, -np.pi / 2), (1.0001, np.nan), (-np.inf, np.nan)],
    "acos": [(1.0, 0.0), (0.0, np.pi / 2), (-1.0, np.pi), (-1.0001, np.nan), (np.inf, np.nan)],
    "atan": [(-0.0, -0.0), (1.0, np.pi / 4), (np.inf, np.pi / 2), (-np.inf, -np.pi / 2)],
    "exp": [(0.0, 1.0), (-0.0, 1.0), (np.inf, np.inf), (-np.inf, 0.0), (711.0, np.inf), (-750.0, 0.0)],
    "log": [(1.0, 0.0), (0.0, -np.inf), (-0.0, -np.inf), (-1.0, np.nan), (np.inf, np.inf), (-np.inf, np.nan)],
    "sqrt": [(-0.0, -0.0), (-1.0, np.nan), (np.inf, np.inf), (4.0, 2.0)],
}


@pytest.mark.parametrize("name", UNARY_CASES)
def test_special_values(scalar: Arithmetic, name: str) -> None:
    with np.errstate(over="ignore"):
        x, expected = np.array([*UNARY_CASES[name], (np.nan, np.nan)]).T.astype(scalar.dtype)
    _assert_identical(scalar(name, x), expected)


@pytest.mark.parametrize("name", ["floor", "ceil", "sign", "fabs"])
def test_steps(scalar: Arithmetic, name: str) -> None:
    steps = np.arange(-4, 4, 0.25)
    near = np.nextafter(scalar.dtype(1), scalar.dtype(0))
    edge = 2.0 ** np.finfo(scalar.dtype).nmant
    x = np.array([*steps, *SPECIAL, near, -near, edge - 0.5, edge + 1, 0.5 - edge, -1e-30], scalar.dtype)
    expected = getattr(np, name)(x)
    if name == "sign":
        expected = np.where(x == 0, x, expected)  # NumPy's sign(-0.0) is +0.0
    _assert_identical(scalar(name, x), expected)


BINARY_REFERENCE: dict[str, Callable[[Array, Array], Array]] = {
    "atan2": np.arctan2, "pow": np.power, "min": np.fmin, "max": np.fmax, "copysign": np.copysign,
    "fmod": np.fmod,
}  # fmt: skip


@pytest.mark.parametrize("name", BINARY_REFERENCE)
def test_special_pairs(scalar: Arithmetic, name: str) -> None:
    """The C library's rules for zeros, infinities, NaN, integer exponents and quadrants."""
    x, y = np.meshgrid(*[np.array([*SPECIAL, -2.5, 7.0, 2.0**52 + 1, 2.0**70], scalar.dtype)] * 2)
    with np.errstate(all="ignore"):
        expected = BINARY_REFERENCE[name](x, y)
    got = scalar(name, x, y)
    np.testing.assert_array_max_ulp(np.nan_to_num(got), np.nan_to_num(expected), maxulp=2)
    np.testing.assert_array_equal(np.isfinite(got), np.isfinite(expected))
    np.testing.assert_array_equal(np.isnan(got), np.isnan(expected))
    signs = ~np.isnan(expected) & ~((expected == 0) & (name in ("min", "max")))
    np.testing.assert_array_equal(np.signbit(got)[signs], np.signbit(expected)[signs])


def test_hypotenuse(scalar: Arithmetic) -> None:
    _assert_identical(scalar("hypot", [3.0, -0.0, -np.inf], [-4.0, 0.0, 1.0]), np.array([5.0, 0.0, np.inf]))


def test_nan_is_ignored_by_min_and_max_only(scalar: Arithmetic) -> None:
    assert scalar("min", np.nan, [1.0])[0] == scalar("max", [1.0], np.nan)[0] == 1.0
    for name in (*OWN_UNARY, *LIBM_UNARY):
        assert np.isnan(scalar(name, [np.nan])).all(), name
    for name in ("atan2", "hypot", "pow", "fmod"):
        assert np.isnan(scalar(name, [np.nan, 2.0, np.nan], [2.0, np.nan, np.nan])).all(), name


def test_sine_and_cosine_stay_bounded(scalar: Arithmetic) -> None:
    x = np.geomspace(1.0, 1e38, 20001)
    s, c = scalar("sin", x), scalar("cos", x)
    assert max(np.abs(s).max(), np.abs(c).max()) <= 1.0
    assert np.abs(s.astype(float) ** 2 + c.astype(float) ** 2 - 1).max() < 16 * np.finfo(scalar.dtype).eps
    _assert_identical(scalar("sin", -x), -s)
    _assert_identical(scalar("sine_of_sincos", x), s)
    _assert_identical(scalar("cosine_of_sincos", x), c)


def test_masks(scalar: Arithmetic) -> None:
    x, y = (v.ravel() for v in np.meshgrid(np.array(SPECIAL, scalar.dtype), np.array(SPECIAL, scalar.dtype)))
    expected = {
        "lt": x < y, "le": x <= y, "eq": x == y, "ne": x != y, "lt_constant": x > 0.5, "not": ~(x < y),
        "and": (x < y) & (x > 0), "or": (x < y) | (x > 0), "truth": x != 0,
    }  # fmt: skip
    for name, mask in expected.items():
        _assert_identical(scalar(name, x, y), np.where(mask, 1.0, 0.0))


def test_select_passes_nothing_from_the_branch_not_taken(scalar: Arithmetic) -> None:
    x, y = np.array([1.0, 2.0, np.nan, 2.0, -np.inf, 2.0]), np.array([2.0, 1.0, 1.0, np.nan, np.inf, -np.inf])
    _assert_identical(scalar("select", x, y), np.where(x < y, x, 2 * y))
    _assert_identical(scalar("select0", x, y), np.where(x < y, x, 0.0))
    _assert_identical(scalar("splat", [0.0, 1.0]), np.array([0.1, -0.0]))


def test_constants_mix_with_numbers(scalar: Arithmetic) -> None:
    x, y = _samples("infix", scalar.dtype)
    t = scalar.dtype
    _assert_identical(scalar("infix", x, y), (t(1) - x) * t(0.1) + -y / t(3))


@pytest.mark.parametrize("dtype", DTYPES, ids=["double", "float"])
def test_needs_no_c_library(dtype: Any, tmp_path: Path) -> None:
    """Nothing is left undefined in a free-standing library, so a board needs no libm."""
    compiler = require_compiler()
    (tmp_path / "board.c").write_text(_harness(OWN) + "#ifdef MEHVAR_PRIVATE_LIBM_H\n#error hosted\n#endif\n")
    flags = [*_flags(dtype, 1), *compiler.flags, "-O2", "-ffreestanding", "-nostdlib", "-Wl,-z,defs"]
    _run([*compiler.command, *flags, "board.c", "-o", "board.so"], tmp_path)


@pytest.mark.parametrize("flag", ["-DMEHVAR_LANES=3", "-ffast-math"])
def test_refuses_what_it_cannot_keep_exact(flag: str, tmp_path: Path) -> None:
    compiler = require_compiler()
    (tmp_path / "harness.c").write_text(_harness(OWN))
    with pytest.raises(AssertionError, match=r"MEHVAR_LANES must be|own precision"):
        _run([*compiler.command, f"-I{INCLUDE}", flag, "-fsyntax-only", "harness.c"], tmp_path)
