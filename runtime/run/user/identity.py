# SPDX-License-Identifier: Apache-2.0
"""Identity of a Python law: its code, and all outside values and functions that it reads."""

from __future__ import annotations

import builtins
import dis
import functools
import hashlib
import importlib
import inspect
import os
import sys
import sysconfig
from collections import OrderedDict, defaultdict, namedtuple
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from types import (
    BuiltinFunctionType,
    CodeType,
    FunctionType,
    MemberDescriptorType,
    MethodType,
    ModuleType,
    SimpleNamespace,
)
from typing import Any, TypeGuard

import numpy as np

_LOADS = {"LOAD_GLOBAL", "LOAD_NAME", "LOAD_DEREF", "LOAD_CLASSDEREF"} | {
    *("LOAD_FROM_DICT_OR_GLOBALS", "LOAD_FROM_DICT_OR_DEREF"),
}
"""Instructions, of Python 3.11 and later, that load outside names."""
_ATTRIBUTES = {"LOAD_ATTR", "LOAD_METHOD"}
_PLAIN = (bool, int, float, complex, str, bytes, type(None), type(Ellipsis))
_FIELDS = (MemberDescriptorType, type(vars(namedtuple("_Pair", "one"))["one"]))
"""Types of class attributes for __slots__ entries and named tuple fields."""
_INSTALLED = {"site-packages", "dist-packages"}
_STANDARD = tuple(Path(sysconfig.get_path(name)).resolve() for name in ("stdlib", "platstdlib"))
"""Folders of installed modules and of Python, whose files do not change between runs of a batch."""
_LONGEST = 200
"""Largest number of characters of a shown value; longer ones, such as tables, are shown by digest."""
_OPEN: tuple[object, ...] = (
    *(eval, exec, compile, globals, locals, vars, __import__, importlib.import_module, importlib.__import__),
    *(sys.modules, sys._getframe, inspect.currentframe, inspect.stack),
    *(os.environ, os.getenv, getattr(os, "environb", os.environ), getattr(os, "getenvb", os.getenv)),
)
"""Objects that give access to any object by a computed name, or to the start conditions of the process."""
_OPEN_MODULES = {"builtins", "gc", "importlib", "inspect", "os", "sys"}
_MOVING: tuple[object, ...] = (
    *(open, input, id, hash, np.load, np.loadtxt, np.genfromtxt, np.fromfile, np.memmap),
    *(np.geterr, np.geterrcall, np.getbufsize, np.get_printoptions),
)
_MOVING_MODULES = {
    *("time", "datetime", "random", "_random", "secrets", "uuid", "numpy.random", "os", "posix", "nt", "sys"),
    *("io", "_io", "pathlib", "tempfile", "socket", "subprocess", "threading", "multiprocessing", "platform", "psutil"),
    *("decimal", "_decimal", "_pydecimal", "contextvars", "_contextvars", "locale", "_locale", "warnings", "signal"),
}
"""Objects whose results depend on time or process: clocks, generators, files, machine, interpreter settings,
contexts such as decimal precision."""
_OPEN_NAMES = {"__globals__", "__builtins__", "__annotations__", "__subclasses__"} | {
    *("f_globals", "f_locals", "f_builtins", "f_back", "gi_frame", "tb_frame"),
}
"""Attributes that give access beyond an object's contents."""
_SHOWN = (
    *(object, list, tuple, dict, set, frozenset, OrderedDict, defaultdict, *_PLAIN, np.ndarray),
    *(SimpleNamespace, functools._lru_cache_wrapper),
)
"""C types with completely visible contents. Other types may have hidden state."""


class UnidentifiedError(Exception):
    """Error for a law that reads something unidentifiable, which the message names."""


def identify(function: Callable[..., Any]) -> tuple[str, str]:
    """Return a function's code with everything it reads, or the part that is unidentifiable."""
    try:
        return source(function), ""
    except UnidentifiedError as error:
        return "", str(error)


def source(function: Callable[..., Any]) -> str:
    """Return a function's code and everything it reads from outside, one line each.

    Raises
    ------
    UnidentifiedError
        If something that it reads cannot be identified.
    """
    if not isinstance(function, FunctionType | MethodType):
        raise UnidentifiedError(f"{type(function).__name__} is not a function with source code")
    try:
        text = inspect.getsource(function)
    except (OSError, TypeError):  # typed at a prompt: the digest of its code identifies it
        text = f"def {function.__name__}: source not found"
    if function.__name__ == "<lambda>":
        raise UnidentifiedError("a lambda cannot be recorded: define the law with def")
    walk = _Walk()
    try:
        walk.value(function.__name__, function)
    except (RecursionError, ValueError, AttributeError) as error:  # nested too deeply, or a name without a value
        raise UnidentifiedError(f"the values that {function.__name__} reads cannot be found: {error}") from error
    return "\n".join([text.rstrip("\n"), *walk.lines()])


class _Walk:
    """Search of all objects that are reachable from a function."""

    def __init__(self) -> None:
        self._lines: dict[str, str] = {}
        self._seen: dict[int, object] = {}

    def lines(self) -> list[str]:
        return [f"{name} = {text}" for name, text in sorted(self._lines.items())]

    def value(self, name: str, value: Any) -> None:
        """Add the value of a name."""
        if isinstance(value, ModuleType):
            raise UnidentifiedError(
                f"the module {name} is used as a whole: read its numbers by name, as in {name}.NAME"
            )
        if any(value is open_ for open_ in _OPEN):
            raise UnidentifiedError(f"{name} is read as a whole: read the values that the law needs by name")
        _refuse_moving(name, value)
        if _is_number(value) and _is_installed(type(value)) and not _held(value):
            self._lines[name] = _shown(value)
            return
        if id(value) in self._seen:
            self._lines.setdefault(name, "as above")
            return
        self._seen[id(value)] = value
        self._object(name, value)

    def _object(self, name: str, value: Any) -> None:
        """Record what determines an object's behaviour: code of the user, or name and version of an installed one."""
        owner = value if isinstance(value, type | FunctionType) else type(value)
        if isinstance(value, MethodType):
            self.value(f"{name}.__func__", value.__func__)
            self.value(f"{name}.__self__", value.__self__)
        elif isinstance(value, FunctionType) and not _is_installed(owner):
            self._function(name, value)
        elif isinstance(value, type) and not _is_installed(owner):
            self._class(name, value)
        elif isinstance(value, type | FunctionType | BuiltinFunctionType | np.ufunc):
            if isinstance(value, np.ufunc) and all(set(types) <= set("O->") for types in value.types):
                raise UnidentifiedError(f"{name} was made by numpy.frompyfunc, which hides its function")
            self._lines[name] = _known_as(value)
            if _is_bound(value):
                self.value(f"{name}.__self__", value.__self__)
        else:
            self._instance(name, value)

    def _class(self, name: str, value: type) -> None:
        self._lines[name] = f"class {value.__qualname__}"
        if type(value) is not type:
            self.value(f"{name}.__class__", type(value))
        for base in value.__bases__:
            self.value(f"{name}({base.__qualname__})", base)
        self._members(name, {key: part for key, part in vars(value).items() if key not in _OF_EACH_CLASS})

    def _instance(self, name: str, value: Any) -> None:
        """Add an object's contents: parts, attributes and class."""
        kind, plain = type(value), True
        if isinstance(value, list | tuple | set | frozenset):
            parts = sorted(value, key=repr) if isinstance(value, set | frozenset) else value
            self._parts(name, kind.__name__, {f"[{i}]": part for i, part in enumerate(parts)})
        elif isinstance(value, dict):
            named = {f"[{key!r}]": part for key, part in value.items() if _is_key(name, key)}
            self._parts(name, f"dict {_shown(list(named))}", named)
            self._members(name, {"default_factory": getattr(value, "default_factory", None)})
        elif _is_number(value):
            self._lines[name] = _shown(value)
        else:
            plain = False
        if not (isinstance(value, np.generic) or _made_in(kind) in _SHOWN) or not (
            plain or _held(value) or not _is_installed(kind)
        ):
            raise UnidentifiedError(f"{name} is of {kind.__module__}.{kind.__qualname__}, whose state cannot be read")
        if not _is_installed(kind) or not plain:
            self.value(f"{name}.__class__", kind)
        self._members(name, _held(value))

    def _parts(self, name: str, kind: str, parts: Mapping[str, Any]) -> None:
        self._lines[name] = f"{kind} of {len(parts)}"
        for key, part in parts.items():
            self.value(f"{name}{key}", part)

    def _members(self, name: str, members: Mapping[str, Any]) -> None:
        for key, part in members.items():
            if isinstance(part, _FIELDS):  # each object has its own value
                continue
            inner = getattr(part, "__func__", None) or getattr(part, "fget", None) or part
            self.value(f"{name}.{key}", inner)

    def _function(self, name: str, function: FunctionType) -> None:
        self._lines[name] = f"def {function.__qualname__}, code {_digest(_code(function.__code__))}"
        held = {"defaults": function.__defaults__, "keywords": function.__kwdefaults__, "__doc__": function.__doc__}
        self._members(name, {key: value for key, value in held.items() if value})
        self._members(name, vars(function))
        cells = dict(zip(function.__code__.co_freevars, function.__closure__ or (), strict=True))
        for path in dict.fromkeys(_reads(function.__code__)):
            self._read(name, path, function, cells)

    def _read(self, where: str, path: tuple[str, ...], function: FunctionType, cells: Mapping[str, Any]) -> None:
        """Record the value behind a dotted name that a function uses; refuse values that change by themselves."""
        first, *rest = path
        if first in cells:
            value, name = cells[first].cell_contents, f"{where}: {first}"
        elif first in function.__globals__:
            value, name = function.__globals__[first], f"{function.__module__}.{first}"
        elif any(getattr(builtins, first, None) is open_ for open_ in (*_OPEN, *_MOVING)):
            value, name = getattr(builtins, first), f"{where}: {first}"
        else:
            return  # of Python itself, or a local name
        module = None
        while isinstance(value, ModuleType) and rest:
            module, name, value = value, f"{value.__name__}.{rest[0]}", getattr(value, rest.pop(0), None)
        if isinstance(value, ModuleType) and _is_installed_module(value) and value.__name__ not in _OPEN_MODULES:
            _refuse_moving(name, value)
            self._lines[value.__name__] = _version(value)
        elif module is not None and _is_installed_module(module) and _comes_with_python(value):
            _refuse_moving(name, value)
            self._lines[name] = _version(module)
        else:
            self.value(name, value)


def _refuse_moving(name: str, value: object) -> None:
    owner = getattr(value, "__self__", None)
    module = value.__name__ if isinstance(value, ModuleType) else getattr(value, "__module__", None)
    if any(value is moving for moving in _MOVING) or _is_moving(str(module or type(owner).__module__)):
        raise UnidentifiedError(
            f"{name} depends on more than t and x, such as clock, random numbers, files or settings: use only t and x"
        )


def _is_moving(module: str) -> bool:
    parts = module.split(".")
    return any(".".join(parts[: i + 1]) in _MOVING_MODULES for i in range(len(parts)))


_OF_EACH_CLASS = frozenset(
    ("__module__", "__dict__", "__weakref__", "__qualname__", "__annotations__", "__static_attributes__")
) | {"__firstlineno__", "__dataclass_fields__", "__dataclass_params__", "__match_args__", "__slots__"}


def _reads(code: CodeType) -> Iterator[tuple[str, ...]]:
    """Yield the outside names that code loads, each with the attributes that it accesses directly.

    Raises
    ------
    UnidentifiedError
        If the code imports, or writes global names.
    """
    hidden = _OPEN_NAMES & {*code.co_names, *(part for part in code.co_consts if isinstance(part, str))}
    if hidden:
        raise UnidentifiedError(
            f"{code.co_name} reads {min(hidden)}, through which it can reach any object: read the values by name"
        )
    path: tuple[str, ...] = ()
    for step in dis.get_instructions(code):
        if path and step.opname in _ATTRIBUTES:
            path = (*path, str(step.argval))
            continue
        if path:
            yield path
        if step.opname == "IMPORT_NAME" and not _imports_installed(str(step.argval)):
            raise UnidentifiedError(
                f"{code.co_name} imports {step.argval} during a run: import it at the top of the file"
            )
        if step.opname in ("STORE_GLOBAL", "DELETE_GLOBAL"):
            raise UnidentifiedError(f"{code.co_name} sets the global {step.argval}: keep numbers in the law's memory")
        path = (str(step.argval),) if step.opname in _LOADS else ()
    if path:
        yield path
    for part in code.co_consts:
        if isinstance(part, CodeType):
            yield from _reads(part)


def _code(code: CodeType) -> str:
    """Return the operations of code without line numbers and file."""
    constants = [_code(c) if isinstance(c, CodeType) else _canonical(c) for c in code.co_consts]
    names = (code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars)
    flags = (code.co_argcount, code.co_posonlyargcount, code.co_kwonlyargcount, code.co_flags)
    return repr((sys.version_info[:2], code.co_code.hex(), constants, names, flags))


def _canonical(value: object) -> str:
    return f"set {sorted(map(repr, value))}" if isinstance(value, frozenset) else repr(value)


def _is_number(value: object) -> bool:
    return isinstance(value, _PLAIN) or (isinstance(value, np.ndarray | np.generic) and value.dtype.kind in "biufcUS")


def _shown(value: Any) -> str:
    array = isinstance(value, np.ndarray)
    layout = f"array {value.dtype} {value.shape} {value.strides}" if array else ""
    text = f"{layout} {value.tolist()}" if array else f"{type(value).__name__} {value!r}"
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST // 4]}... {_digest(text)}"


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:32]


def _is_key(name: str, key: object) -> bool:
    if not isinstance(key, (*_PLAIN, tuple)):
        raise UnidentifiedError(f"{name} has the key {key!r}: must be a number or a text")
    return True


def _held(value: object) -> Mapping[str, Any]:
    """Return the instance attributes of an object."""
    slots = [name for kind in type(value).__mro__ for name in getattr(kind, "__slots__", ())]
    return {**{name: getattr(value, name) for name in slots if hasattr(value, name)}, **getattr(value, "__dict__", {})}


def _made_in(kind: type) -> type:
    """Return the C type that creates a class's objects."""
    return next(base for base in kind.__mro__ if isinstance(vars(base).get("__new__"), BuiltinFunctionType))


def _comes_with_python(value: object) -> bool:
    """Return True for an attribute of an installed module, except numbers and tables that users may set."""
    if _is_number(value) or isinstance(value, list | tuple | set | dict) or any(value is open_ for open_ in _OPEN):
        return False
    if _is_bound(value):
        return False
    return _is_installed(value if isinstance(value, type | FunctionType) else type(value))


def _is_bound(value: object) -> TypeGuard[BuiltinFunctionType]:
    """Return True for a bound C method such as ``{"soft": 1.0}.get``, which reads its object."""
    return isinstance(value, BuiltinFunctionType) and not isinstance(value.__self__, ModuleType | type(None))


def _is_installed(owner: Any) -> bool:
    module = sys.modules.get(owner.__module__)
    return module is not None and _is_installed_module(module)


def _is_installed_module(module: ModuleType) -> bool:
    file = getattr(module, "__file__", None)
    if module.__name__.partition(".")[0] == "mehvar":
        return True
    if file is None:
        return module.__name__ in sys.stdlib_module_names
    path = Path(file).resolve()
    return not _INSTALLED.isdisjoint(path.parts) or any(path.is_relative_to(folder) for folder in _STANDARD)


def _imports_installed(name: str) -> bool:
    module = sys.modules.get(name)
    if name.partition(".")[0] in _OPEN_MODULES or _is_moving(name):
        return False
    return name in sys.stdlib_module_names or (module is not None and _is_installed_module(module))


def _known_as(value: Any) -> str:
    module = str(getattr(value, "__module__", None) or type(value).__module__)
    name = getattr(value, "__qualname__", None) or getattr(value, "__name__", type(value).__qualname__)
    return f"{module}.{name} {_version(sys.modules.get(module))}".rstrip()


def _version(module: ModuleType | None) -> str:
    """Return the version of a module's package."""
    package = sys.modules.get(module.__name__.partition(".")[0]) if module is not None else None
    return str(getattr(package, "__version__", f"Python {sys.version_info[0]}.{sys.version_info[1]}"))
