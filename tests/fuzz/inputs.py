# SPDX-License-Identifier: Apache-2.0
"""Inputs of a confused, hurried or hostile user, from a seed: values, expressions, commands, campaign files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from random import Random

from mehvar.runtime.run.options import OPTIONS

PENDULUM = Path(__file__).parents[1] / "runtime" / "pendulum"
NASTY = (
    *("", " ", "0", "-0.0", "-1", "1e300", "-1e300", "1e-320", "1e308", "nan", "inf", "-inf", "1e400", "1" * 400),
    *("9" * 5000, "True", "False", "None", "0x10", "1_0", "٣", "é", "\udcff", "2147483648", "18446744073709551615"),
    *("1/0", "[]", "{}", "()", "1,2", "--", "-", "=", "1 2", "rk4", "c", "python", "float", "a\nb", "'", '"', "\\"),
    *("%s", "{0}", "normal(0,1)", "*", "..", "/", "/dev/null", "/no/such", "x" * 300, "-n", "--help", "2.0", "1e-9"),
)
"""Values at and beyond the limits of ranges, parsers, printf and file systems; none needs a long run."""
_PLAIN = {
    **{"t_end": "0.05", "dt_out": "0.01", "hold": "0.01", "delay": "1", "seed": "3", "run": "2", "real": "float"},
    **{"method": "rk4", "rtol": "1e-6", "atol": "1e-6", "step": "0.005", "max_steps": "500", "backend": "c"},
    **{"profile": "fast", "m": "1.5", "k_p": "16", "k_d": "2", "rate_0": "0.1", "nonsense": "1"},
}
assert OPTIONS.keys() <= _PLAIN.keys()
_NAMES = (
    "T_angle",
    "angle",
    "rate",
    "t_stop",
    "error",
    "final(angle)",
    "maximum(u_torque)",
    "minimum(rate)",
    "nonsense",
)
_LAWS = (*("pd", "p-sum") * 4, "none", "nonsense", "")
_ATOMS = ("1", "0", "20", "1.5e3", "1e999", "1" * 400, "True", "None", "'a'", "x", "()", "[1]", "{}", "λ", "1j", "0x1f")
_OPERATORS = ("<", "<=", ">", ">=", "==", "!=", "+", "-", "*", "/", "//", "%", "**", "and", "or", "is", "in", ",", ":=")


def value(random: Random) -> str:
    """Return a text in place of a number or a word."""
    if random.random() < 0.7:
        return random.choice(NASTY)
    return repr(random.choice((random.uniform(-5, 5), random.randint(-5, 500), 10.0 ** random.randint(-320, 308))))


def expression(random: Random) -> str:
    """Return a condition or a damaged condition."""
    return _condition(random) if random.random() < 0.4 else _wild(random)


def _condition(random: Random, depth: int = 0) -> str:
    pick = random.random()
    if depth < 3 and pick < 0.3:
        return f"({_condition(random, depth + 1)} {random.choice(('and', 'or'))} {_condition(random, depth + 1)})"
    if depth < 3 and pick < 0.4:
        return f"not {_condition(random, depth + 1)}"
    parts = [_number(random) for _ in range(random.choice((2, 2, 2, 3, 5)))]
    return "".join(f"{part} {random.choice(_OPERATORS[:4])} " for part in parts[:-1]) + parts[-1]


def _number(random: Random, depth: int = 0) -> str:
    pick = random.random()
    if depth < 3 and pick < 0.3:
        return f"({_number(random, depth + 1)} {random.choice('+-*/')} {_number(random, depth + 1)})"
    if depth < 3 and pick < 0.4:
        return random.choice(("-{}", "abs({})", "--{}")).format(_number(random, depth + 1))
    return random.choice(_NAMES) if pick < 0.75 else random.choice(("1", "0", "20", "1.5e3", "1e-320", "1e308"))


def _wild(random: Random, depth: int = 0) -> str:
    pick = random.random()
    if depth > 4 or pick < 0.25:
        return random.choice(_NAMES) if random.random() < 0.6 else random.choice(_ATOMS)
    if pick < 0.3:
        return random.choice(("-", "not ", "~", "+", "abs", "lambda: ")) * random.choice((1, 1, 2, 3, 90, 150, 3000))
    if pick < 0.4:
        return f"{random.choice(('-', 'not ', 'abs'))}({_wild(random, depth + 1)})"
    if pick < 0.45:
        return "(" * random.choice((1, 50, 250)) + _wild(random, depth + 1)
    parts = [_wild(random, depth + 1) for _ in range(random.choice((2, 2, 2, 3, 4)))]
    operators = _OPERATORS[:4] if random.random() < 0.6 else _OPERATORS
    return "".join(f"{part} {random.choice(operators)} " for part in parts[:-1]) + parts[-1]


def distribution(random: Random) -> str:
    """Return a distribution or a damaged distribution."""
    kinds = ("normal", "uniform", "lognormal", "triangular", "choice", "sphere", "nonsense", "", "normal.x")
    arguments = [value(random) for _ in range(random.randint(0, 4))]
    if random.random() < 0.5:
        arguments = [repr(random.uniform(-3, 3)) for _ in arguments]
    return f"{random.choice(kinds)}({', '.join(arguments)})"


def damaged(random: Random, text: str) -> str:
    """Return a text with a few characters changed, left out or doubled."""
    letters = list(text)
    for _ in range(random.randint(1, 4)):
        place = random.randrange(len(letters) + 1)
        letters[place : place + random.randint(0, 3)] = random.choice(
            ("", "", "=", "[", "]", '"', "\n", ".", "9", "true", "é", "\x00")
        )
    return "".join(letters)


def campaign(random: Random) -> str:
    """Return a campaign file or a damaged one."""
    words = ("true", "[1]", "{}", "1979-05-27", "-1", "1e400", "nan", '"x"', "9" * 30, "[[1]]", "0.1", "2", '""')
    lines = {
        "model": f'"{PENDULUM}"', "controller": '"pd"', "n": "2", "t_end": "0.05", "seed": "1", "sampling": '"latin"',
        "success": '"T_angle < 1"', "until": '"ci(success) < 0.1"', "save": "{every = 0.01}", "scenario": '"swing"',
        "set": "{m = 1.5}", "initial": "{rate = 0.1}", "vary": '{k_p = "normal(16, 0.1)"}', "nonsense": "1",
    }  # fmt: skip
    names = [name for name in lines if random.random() < (0.95 if name in ("model", "controller", "n") else 0.3)]
    text = "".join(f"{name} = {random.choice(words) if random.random() < 0.2 else lines[name]}\n" for name in names)
    return damaged(random, text) if random.random() < 0.3 else text


def command(random: Random) -> list[str]:
    """Return the arguments of a fast command, valid or not."""
    weights = (20, 20, 4, *(2,) * 8)
    verb = random.choices(tuple(_COMMANDS), (*weights, *(1,) * (len(_COMMANDS) - len(weights))))[0]
    arguments = _COMMANDS[verb](random)
    if random.random() < 0.15:
        arguments.insert(random.randrange(len(arguments) + 1), value(random))
    if arguments and random.random() < 0.1:
        del arguments[random.randrange(len(arguments))]
    return [*verb.split(), *arguments]


def _settings(random: Random) -> list[str]:
    names = random.sample(tuple(_PLAIN), random.choice((0, 0, 1, 1, 2, 3)))
    settings = [f"{name}={value(random) if random.random() < 0.25 else _PLAIN[name]}" for name in names]
    return [word for setting in settings for word in ("--set", setting)]


def _some(random: Random, **flags: Sequence[str]) -> list[str]:
    """Return a few flags with valid or unusual values."""
    chosen = [name for name in flags if random.random() < 0.25]
    return [
        word
        for name in chosen
        for word in (
            f"--{name.replace('_', '-')}",
            *([value(random) if random.random() < 0.4 else random.choice(flags[name])] if flags[name] else []),
        )
    ]


def _simulate(random: Random) -> list[str]:
    return [
        *(str(PENDULUM), "--controller", random.choice(_LAWS), "--t-end", "0.05"),
        *_settings(random),
        *_some(
            random, scenario=("swing", "stiff"), out=("a.nc", "a.csv", "a.mat", "a.xyz", "no/a.nc"), plot=("a.xyz",)
        ),
        *_some(random, input=("torque=1", "torque"), inputs=("in.csv", "c.toml"), interpolation=("linear", "hold")),
        *_some(random, run=("0", "1"), **{"from": ("s.zarr", "none.zarr")}),
    ]


def _batch(random: Random) -> list[str]:
    names = ("m", "k_p", "rate", "angle,rate", "nonsense", "")
    model = str(PENDULUM) if random.random() < 0.8 else random.choice(("c.toml", "none.toml"))
    return [
        *(model, "--controller", random.choice(_LAWS), "-n", random.choice(("1", "2", "2", "5", "5", value(random)))),
        *("--t-end", "0.05", "--out", random.choice(("new.zarr", "s.zarr", "no/new.zarr"))),
        *_settings(random),
        *(("--vary", "k_p=uniform(16, 17)") if random.random() < 0.5 else ()),
        *(("--vary", f"{random.choice(names)}={distribution(random)}") if random.random() < 0.25 else ()),
        *(("--success", expression(random)) if random.random() < 0.3 else ()),
        *(("--save", f"every={value(random)}") if random.random() < 0.2 else ()),
        *_some(random, scenario=("swing",), seed=("1",), sampling=("latin",), until=("ci(success) < 0.1",)),
        *_some(random, threads=("1", "2"), resume=(), strict=(), t_end=("0.02",)),
    ]


_COMMANDS = {
    "simulate": _simulate,
    "batch": _batch,
    "stats": lambda random: [
        random.choice(("s.zarr", "c.toml", "none")),
        *_some(random, success=("T_angle < 1",), plot=("a.xyz",), of=("angle",)),
    ],
    "show": lambda random: [random.choice((str(PENDULUM), value(random)))],
    "new": lambda random: [random.choice(("numpy", "Wheel", "rtol", "triangle", "math", "s.zarr", "calls", "class"))],
    "generate": lambda random: [value(random), *_some(random, structure=("a=b",), emit=("casadi",), check=())],
    "board run": lambda random: [
        *(str(PENDULUM), "--controller", random.choice(("nonsense", "")), *_settings(random)),
        *_some(random, target=("sil",), samples=("2",), compiler=("tcc",), board=("stm32f4",)),
    ],
    "board build": lambda random: [str(PENDULUM), "--controller", "nonsense", *_some(random, target=("qemu",))],
    "verify": lambda random: [random.choice(("s.zarr", "c.toml", "none", value(random)))],
    "convert": lambda random: [
        *(random.choice(("s.zarr", "s.zarr", "none.nc", "c.toml")), "--to", random.choice(("csv", "mat", "xyz"))),
        *_some(random, out=("a.csv", "a.mat", "s.zarr", "no/a.csv")),
    ],
    "diff": lambda random: [
        *(random.choice((str(PENDULUM), "c.toml", "none", value(random))) for _ in range(2)),
        *_some(random, format=("json", "html"), out=("a.html",), model=("pendulum",), paper=()),
    ],
    "board report": lambda random: [str(PENDULUM), "--controller", "nonsense", *_some(random, out=("a",))],
    "board emit": lambda random: [
        *(str(PENDULUM), "--controller", "nonsense", "--out", "a"),
        *("--for", random.choice(("cmake", "zephyr", "nonsense"))),
        *_some(random, range=("a=0:1", "roll=1"), link=()),
    ],
    "board flash": lambda random: [str(PENDULUM), "--controller", "nonsense", *_some(random, board=("none",))],
    "export fmu": lambda random: [
        *(value(random), "--out", random.choice(("a.fmu", "s.zarr", "a.zip"))),
        *_some(random, controller=("pd",), scenario=("swing",), fmi=("2.0", "4"), kind=("me", "nonsense")),
    ],
    "export web": lambda random: [value(random), "--out", random.choice(("pages", "c.toml", "s.zarr"))],
    "git-textconv": lambda random: [random.choice(("c.toml", "none", value(random)))],
    "list": lambda random: [*_some(random, json=())],
    "": lambda random: [value(random)],
}
