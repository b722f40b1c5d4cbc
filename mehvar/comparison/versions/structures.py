# SPDX-License-Identifier: Apache-2.0
"""Structures of a model besides the default: sources that affect them, and folders of both sides."""

from __future__ import annotations

import ast
import json
import os
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mehvar.base.errors import InputError, bad_value, unknown_name
from mehvar.base.manifest import read_manifest
from mehvar.base.schema import parse_toml
from mehvar.codegen.generate import Tree, own_inputs
from mehvar.codegen.structures import all_structures
from mehvar.runtime.model.derived import last_line, run_python
from mehvar.settings import read_settings
from mehvar.terminal import progress

from .sources import Version, derived

ALL = "all"
_WORDS = frozenset(("title", "description"))
"""Keys of tables with texts for people."""
_CALL = """
import json, sys
from pathlib import Path
from mehvar.codegen import structures
from mehvar.codegen.workspace import Tree
print(json.dumps(getattr(structures, sys.argv[1])(Tree(Path.cwd()), *map(json.loads, sys.argv[2:]))))
"""


@dataclass(frozen=True)
class Variant:
    """One structure in both versions.

    Attributes
    ----------
    name : str
        As in "inertia=ball,attitude=quaternion".
    old, new : Path or str
        Generated folder of each side, or the reason why there is none.
    """

    name: str
    old: Path | str
    new: Path | str

    @property
    def is_refused(self) -> bool:
        """True if both sides refuse the structure."""
        return isinstance(self.old, str) and isinstance(self.new, str)


@dataclass(frozen=True)
class Selection:
    """Structures to compare besides the default, and True if these are all."""

    variants: tuple[Variant, ...]
    complete: bool


def changed_sources(model: str, old: Version, new: Version) -> tuple[str, ...]:
    """Return changed files on which structures depend that were not compared; comments and layout do not count.

    Empty for a model without structural choices.
    """
    records = [read_manifest(side.folders[model], any_age=True) for side in (old, new)]
    if not any(record.structure for record in records):
        return ()
    trees = [side.tree for side in (old, new) if side.tree is not None]
    before, after = ({k: v for k, v in record.inputs_sha256.items() if _is_own(k, trees)} for record in records)
    names = sorted(name for name in {*before, *after} if before.get(name) != after.get(name))
    return tuple(name for name in names if not (len(trees) == 2 and _means_the_same(name, *trees)))


def _is_own(name: str, trees: Sequence[Tree]) -> bool:
    if not trees:
        return not name.startswith(("codegen/", "mehvar/"))
    return any(own_inputs(tree, {name: ""}) for tree in trees)


def _means_the_same(name: str, old: Tree, new: Tree) -> bool:
    """Return True if two files differ only in comments, layout and texts for people."""
    try:
        before, after = (_meaning(tree.root / name) for tree in (old, new))
    except (OSError, ValueError, SyntaxError):
        return False
    return before == after


def _meaning(path: Path) -> object:
    """Return what a source defines, without comments and docstrings, which change no equation."""
    content = path.read_bytes()
    if path.suffix == ".toml":
        return _without_words(parse_toml(content.decode("utf-8-sig")))
    if path.suffix != ".py":
        return content
    tree = ast.parse(content)
    for node in ast.walk(tree):
        match body := getattr(node, "body", None):
            case [ast.Expr(value=ast.Constant()), *_]:
                del body[0]  # a docstring
    return ast.dump(tree)


def _without_words(value: object) -> object:
    if isinstance(value, dict):
        return {key: _without_words(entry) for key, entry in value.items() if key not in _WORDS}
    # 1, 1.0 and True are equal in Python, but not in a table
    return [*map(_without_words, value)] if isinstance(value, list) else (type(value).__name__, value)


def selection(model: str, old: Version, new: Version, texts: Sequence[str]) -> Selection:
    """Return the structures that a user names, derived on both sides or taken from the cache.

    Parameters
    ----------
    model : str
        Its name.
    old, new : Version
        Both sides; both must have models/.
    texts : sequence of str
        "all", or NAME=VALUE of the choices that differ from the defaults, with commas between them.

    Raises
    ------
    InputError
        If a side has no models/, or a choice or a value is not known.
    """
    if not texts:
        return Selection((), False)
    for side in (old, new):
        if side.tree is None or model not in side.tree.models:
            raise InputError(
                f"--structures derives {model} on both sides: {side.label} has no models/{model}: leave it out"
            )
    choices: dict[str, tuple[str, ...]] = _call(old, "choices_of", model) | _call(new, "choices_of", model)
    every, complete = all_structures(choices)
    chosen = [structure for text in texts for structure in (every if text == ALL else [_read(text, choices)])]
    unique = list({_name(structure): structure for structure in chosen}.values())
    with progress(f"deriving {len(unique)} structures of {model}"), ThreadPoolExecutor(os.cpu_count()) as pool:
        variants = pool.map(lambda structure: _variant(model, old, new, structure), unique)
        several = {variant.name: variant for variant in variants}.values()
    return Selection(
        tuple(sorted(several, key=lambda variant: variant.name.count(","))),
        {*map(_name, every)} <= {*map(_name, unique)} and complete,
    )


def _name(structure: Mapping[str, str]) -> str:
    return ",".join(f"{name}={value}" for name, value in sorted(structure.items()))


def _read(text: str, choices: Mapping[str, Sequence[str]]) -> dict[str, str]:
    """Read NAME=VALUE[,NAME=VALUE] and drop values that are defaults."""
    structure = read_settings(text.split(","), "--structures")
    for name, value in structure.items():
        if name not in choices:
            raise unknown_name("structure", name, choices, "--structures")
        if value not in choices[name]:
            raise bad_value(f"structure {name}", value, f"one of {', '.join(choices[name])}", "--structures")
    return {name: value for name, value in structure.items() if value != choices[name][0]}


def _variant(model: str, old: Version, new: Version, structure: Mapping[str, str]) -> Variant:
    """Derive a structure on both sides. If both refuse it, add the choices that it requires."""
    variant = _derived(model, old, new, structure)
    if not variant.is_refused:
        return variant
    wider = _call(new, "valid_structure", model, structure)
    return variant if wider in (None, structure) else _derived(model, old, new, wider)


def _derived(model: str, old: Version, new: Version, structure: Mapping[str, str]) -> Variant:
    def side(version: Version) -> Path | str:
        assert version.tree is not None
        try:
            return derived(version.tree, model, version.label, structure)
        except InputError as error:
            return str(error)

    return Variant(_name(structure), side(old), side(new))


def _call(version: Version, function: str, *arguments: object) -> Any:
    """Call a function of `codegen.structures` in a new process, without models of this one."""
    assert version.tree is not None
    process = run_python(version.tree.root, "-c", _CALL, function, *map(json.dumps, arguments))
    if process.returncode:
        raise InputError(f"{version.label}: the structures cannot be read: {last_line(process) or 'no answer'}")
    return json.loads(process.stdout)
