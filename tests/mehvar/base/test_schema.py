# SPDX-License-Identifier: Apache-2.0
"""Dataclasses as JSON and back: what is written is read again, what does not fit is refused with its place."""

import json
import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, NamedTuple

import pytest

from mehvar.base.errors import MehvarError
from mehvar.base.manifest import FILE, manifest_text, read_manifest
from mehvar.base.names import identifier
from mehvar.base.schema import Lower, SchemaError, Upper, json_key, parse_toml, plain, read
from mehvar.codegen.generate import Tree, installed_tree
from mehvar.models.tables import read_parameters


class Pair(NamedTuple):
    name: str
    size: int | None


@dataclass(frozen=True)
class Leaf:
    name: str
    low: Lower
    high: Upper
    note: str | None = None


@dataclass(frozen=True)
class Root:
    leaves: Mapping[str, Leaf]
    rows: tuple[Leaf, ...]
    pairs: tuple[Pair, ...] = field(metadata=json_key("list"))
    place: str = field(default="", metadata=json_key(None))


def data() -> dict:
    row = {"name": "r", "low": None, "high": 2, "note": None}
    return {"leaves": {"a": {"low": -1.0, "high": None, "note": "n"}}, "rows": [row], "list": [["x", 3], ["t", None]]}


def test_what_is_read_is_written_again():
    root = read(Root, data())
    assert root.leaves["a"] == Leaf("a", -1.0, math.inf, "n")
    assert root.rows == (Leaf("r", -math.inf, 2.0),)
    assert root.pairs == (Pair("x", 3), Pair("t", None))
    assert root.place == ""
    assert type(root.rows[0].high) is float
    assert plain(Root, root) == data()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda d: d.pop("rows"), "rows is missing"),
        (lambda d: d.update(raws=1), "raws is not known"),
        (lambda d: d["leaves"]["a"].pop("note"), "leaves.a.note is missing"),
        (lambda d: d["leaves"]["a"].update(low="0"), "leaves.a.low = '0': must be a number"),
        (lambda d: d["leaves"].update(b=[]), r"leaves.b = \[\]: must be a table"),
        (lambda d: d["rows"][0].update(high=True), r"rows\[0\].high = True: must be a number"),
        (lambda d: d["rows"][0].update(name=None), r"rows\[0\].name = None: must be a text"),
        (lambda d: d["list"].append(["y"]), r"list\[2\] = \['y'\]: must be \[name, size\]"),
        (lambda d: d["list"].append(["y", 1.5]), r"list\[2\] = 1.5: must be a whole number"),
        (lambda d: d.update(list="x" * 500), r"list = 'x+ \.\.\. x+': must be a list"),
    ],
)
def test_what_does_not_fit_is_refused_with_its_place(change, message):
    damaged = data()
    change(damaged)
    with pytest.raises(SchemaError, match=f"^{message}$"):
        read(Root, damaged)


def test_data_of_another_version_is_read_on_request():
    other = data()
    del other["rows"][0]["note"]
    other["leaves"]["a"]["colour"] = "red"
    assert read(Root, other, "any_age") == read(Root, data())
    del other["rows"][0]["low"]
    with pytest.raises(SchemaError, match=r"^rows\[0\].low is missing$"):
        read(Root, other, "any_age")


@dataclass(frozen=True)
class Written:
    way: Literal["up", "down"]
    at: tuple[float, str]
    free: Any = None
    path: Path | None = None
    leaves: Mapping[str, Leaf] = field(default_factory=dict, metadata=json_key("set"))


def test_a_table_that_people_write_has_the_names_of_fields_and_may_lack_defaults():
    leaf = {"low": 1, "high": 2.0}
    table = {"way": "up", "at": [1, "m"], "path": "a/b", "leaves": {"a": leaf}}
    assert read(Written, table, "table") == Written("up", (1.0, "m"), None, Path("a/b"), {"a": Leaf("a", 1.0, 2.0)})


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"way": "left"}, "way = 'left': must be up or down"),
        ({"way": ["up"]}, r"way = \['up'\]: must be up or down"),
        ({"at": [1]}, r"at = \[1\]: must be a list of 2"),
        ({"path": 3}, "path = 3: must be a text"),
        ({"set": {}}, "set is not known; known: way, at, free, path, leaves"),
        ({"pat": "a"}, r"pat is not known \(did you mean 'path'\?\)"),
        ({"leaves": {"a": {"name": "b", "low": 1, "high": 2}}}, "leaves.a.name is not known.*"),
    ],
)
def test_what_people_write_wrong_is_told_with_what_is_right(change, message):
    with pytest.raises(SchemaError, match=f"^{message}$"):
        read(Written, {"way": "up", "at": [1, "m"], **change}, "table")


@pytest.mark.parametrize("model", installed_tree().models)
def test_a_manifest_is_read_and_written_to_the_byte(model):
    folder = installed_tree().root / "generated" / model
    text = (folder / FILE).read_text(encoding="utf-8")
    assert manifest_text(read_manifest(folder)) == text
    assert "NaN" not in text
    assert json.loads(text)["schema"] == 1


def test_names_in_code():
    assert [identifier(name) for name in ("lyapunov-v1", "p sum", "é")] == ["lyapunov_v1", "p_sum", "_"]


DEEP = f"a = {'[' * 20_000}"
"""Deeper than any limit of recursion that tests set."""


def test_toml_that_is_nested_too_deeply_is_no_toml():
    with pytest.raises(tomllib.TOMLDecodeError, match="nested too deeply"):
        parse_toml(DEEP)


def test_every_reader_of_toml_is_ours():
    """The one of Python ends in RecursionError."""
    root = Path(__file__).parents[3]
    files = [path for room in ("mehvar", "runtime", "codegen", "models") for path in (root / room).rglob("*.py")]
    readers = {
        path.relative_to(root).as_posix() for path in files if "tomllib.load" in path.read_text(encoding="utf-8")
    }
    assert readers == {"mehvar/base/schema.py"}


@pytest.mark.parametrize("name", ["parameters.toml", "scenarios.toml", "plant.toml"])
def test_a_table_that_is_nested_too_deeply_is_refused_by_its_name(name, tmp_path):
    (tmp_path / "models" / "deep").mkdir(parents=True)
    for each in {name, "parameters.toml"}:
        (tmp_path / "models" / "deep" / each).write_text(DEEP)
    (tmp_path / "generated").mkdir()
    (tmp_path / "models" / "deep" / "__init__.py").touch()
    with pytest.raises(MehvarError, match=f"{name}.*nested too deeply"):
        read_parameters(tmp_path / "models" / "deep" / name) if name != "plant.toml" else Tree(tmp_path).plant("deep")


@dataclass(frozen=True)
class Settings:
    options: Mapping[str, float | str]


def test_a_union_of_scalars_takes_either_and_nothing_else() -> None:
    assert read(Settings, {"options": {"a": 1, "b": "x"}}).options == {"a": 1.0, "b": "x"}
    with pytest.raises(SchemaError, match=r"options\.a = True: must be a number or a text"):
        read(Settings, {"options": {"a": True}})
