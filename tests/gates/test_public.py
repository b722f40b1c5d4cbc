# SPDX-License-Identifier: Apache-2.0
"""A walk over what people call: every name and argument is documented, no keyword is ignored."""

from __future__ import annotations

import ast
import dataclasses
import importlib
import inspect
import pkgutil
import re
from collections.abc import Callable, Iterator
from enum import Enum
from pathlib import Path
from types import ModuleType

import pytest

import mehvar
from mehvar import codegen, ledger, mechanics, models, pictures, reproduction, runtime


def callables(*modules: ModuleType) -> dict[str, Callable[..., object]]:
    """Return the functions and classes that modules name in `__all__`."""
    values = {f"{module.__name__}.{name}": getattr(module, name) for module in modules for name in module.__all__}
    return {name: value for name, value in values.items() if inspect.isclass(value) or inspect.isfunction(value)}


CALLED = callables(mehvar, runtime)  # what users call directly, as the README, the reference and __all__ name it
PUBLIC = CALLED | callables(ledger, mechanics, pictures, reproduction)  # what papers are written with, too
ANY_KEYWORD: dict[str, Callable[..., object]] = {
    "mehvar.api.simulate": lambda **more: mehvar.simulate("triangle", "path", t_end=0.1, **more),
    "mehvar.api.batch": lambda **more: mehvar.batch("triangle", "path", 2, t_end=0.1, **more),
    "mehvar.estimation.fit.fit": lambda **more: mehvar.fit(
        "triangle", mehvar.simulate("triangle", "path", t_end=0.1), ["k_phi"], "path", **more
    ),
    "mehvar.estimation.margins.margins": lambda **more: mehvar.margins("triangle", "path", **more),
    "mehvar.estimation.tune.tune": lambda **more: mehvar.tune(
        "triangle", "path", ["k_phi"], "final(theta)", vary={"theta_0": "uniform(0.9, 1)"}, n=2, t_end=0.1, **more
    ),
    "mehvar.report.verdicts.require": lambda **more: mehvar.require(
        "triangle", {"r": "quantile(0.5, t_stop) < 9"}, controller="path", n=2, t_end=0.1, **more
    ),
    "mehvar.runtime.run.simulate.simulate": lambda **more: runtime.simulate("triangle", "path", t_end=0.1, **more),
    "mehvar.runtime.model.model.Model.parameters": lambda **more: runtime.load("triangle").parameters(**more),
    "mehvar.runtime.model.model.Model.law_parameters": lambda **more: runtime.load("triangle").law_parameters(
        "path", **more
    ),
    "mehvar.runtime.model.model.Model.state": lambda **more: runtime.load("triangle").state(**more),
}


PACKAGES = (mehvar, models, codegen, runtime)


def modules() -> Iterator[str]:
    for package in PACKAGES:
        yield package.__name__
        for found in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            if not found.name.endswith("__main__"):
                yield found.name


def own(module: object) -> Iterator[tuple[str, object]]:
    """Return the public functions and classes that a module defines."""
    for name, value in vars(module).items():
        defined = inspect.isfunction(value) or inspect.isclass(value)
        if defined and not name.startswith("_") and value.__module__ == module.__name__:
            yield f"{module.__name__}.{name}", value


def documented(text: str) -> set[str]:
    """Return the names in the Parameters and Attributes sections of a NumPy-style docstring."""
    sections = re.split(r"^(\w[\w ]*)\n-{3,}$", inspect.cleandoc(text), flags=re.MULTILINE)
    names: set[str] = set()
    for title, body in zip(sections[1::2], sections[2::2], strict=True):
        if title in ("Parameters", "Attributes"):
            heads = (line.split(" : ")[0] for line in body.splitlines() if re.match(r"\S", line))
            names |= {name.strip().lstrip("*") for head in heads for name in head.split(",")}
    return names


def arguments(value: Callable[..., object]) -> list[str]:
    """Return the arguments that a caller may give."""
    if dataclasses.is_dataclass(value):
        return [field.name for field in dataclasses.fields(value) if field.init and not field.name.startswith("_")]
    return [name for name in inspect.signature(value).parameters if name not in ("self", "args", "kwargs")]


@pytest.mark.parametrize("module", sorted(modules()))
def test_every_public_name_says_what_it_is(module):
    found = importlib.import_module(module)
    assert (found.__doc__ or "").strip(), module
    silent = [name for name, value in own(found) if not (inspect.getdoc(value) or "").strip()]
    assert not silent


def test_every_long_private_function_says_what_it_does():
    """Of ten lines or more; name and types of a shorter one may say all."""
    silent, files = [], [path for package in PACKAGES for path in Path(package.__path__[0]).rglob("*.py")]
    assert len(files) > 400
    for path in files:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            private = isinstance(node, ast.FunctionDef) and re.match(r"_[^_]", node.name)
            if private and node.end_lineno - node.lineno >= 9 and not ast.get_docstring(node):
                silent.append(f"{path}:{node.lineno} {node.name}")
    assert not silent


@pytest.mark.parametrize("name", sorted(PUBLIC))
def test_every_argument_is_documented(name):
    value = PUBLIC[name]
    if inspect.isclass(value) and issubclass(value, (Exception, Enum)):
        return
    text = inspect.getdoc(value) or ""
    missing = set(arguments(value)) - documented(text)
    assert not missing, f"{name} does not document {', '.join(sorted(missing))}"


@pytest.mark.parametrize("name", ANY_KEYWORD)
def test_an_unknown_keyword_is_refused(name):
    with pytest.raises(mehvar.InputError, match="no_such_thing"):
        ANY_KEYWORD[name](no_such_thing=1.0)


def test_every_function_that_takes_any_keyword_is_tried():
    functions = {f"{v.__module__}.{v.__qualname__}": v for v in CALLED.values() if inspect.isfunction(v)}
    for value in filter(inspect.isclass, CALLED.values()):
        methods = inspect.getmembers(value, inspect.isfunction)
        functions |= {f"{value.__module__}.{m.__qualname__}": m for name, m in methods if not name.startswith("_")}
    kinds = {name: [p.kind for p in inspect.signature(f).parameters.values()] for name, f in functions.items()}
    assert {name for name, found in kinds.items() if inspect.Parameter.VAR_KEYWORD in found} == set(ANY_KEYWORD)
