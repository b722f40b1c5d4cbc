# SPDX-License-Identifier: Apache-2.0
"""Nothing outside models/NAME and papers/NAME names a model, one of its parameters, states or memories.

Names count where code can act on them: identifiers, and strings that are a name and nothing else. Words in sentences,
such as the examples of a help text, do not.
"""

from __future__ import annotations

import ast
import json
import re
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[2]
MANIFESTS = [json.loads(path.read_text(encoding="utf-8")) for path in sorted(ROOT.glob("generated/*/manifest.json"))]
MODELS = {manifest["model"] for manifest in MANIFESTS}
_OWN = [ROOT / top / name for name in MODELS for top in ("models", "papers")]
_COMMENT = re.compile(r"/\*.*?\*/|//[^\n]*|\{#.*?#\}", re.DOTALL)
_SUFFIXES = (".py", ".c", ".h", ".js", ".j2")


def quantities(manifest: dict) -> Iterator[str]:
    """Yield the names of all parameters, states, inputs, outputs, references and memories."""
    for key in ("parameters", "scenario_parameters", "states", "inputs", "outputs", "references"):
        yield from (quantity["name"] for quantity in manifest[key])
    for law in manifest["controllers"].values():
        for key in ("parameters", "outputs", "memory"):
            yield from (quantity["name"] for quantity in law.get(key) or ())


def distinctive(name: str) -> bool:
    """Tell a name that stands for one thing from a word or a letter: it has an underscore or a digit in it.

    Words, such as delay, noise or mass, mean other things too.
    """
    return len(name) > 3 and bool(re.search(r"[_0-9]", name))


NAMES = MODELS | {name for manifest in MANIFESTS for name in quantities(manifest) if distinctive(name)}


def code() -> Iterator[Path]:
    """Yield every source file that is no model's and no paper's."""
    for room in ("mehvar", "models", "codegen", "runtime", "papers"):
        for path in sorted((ROOT / room).rglob("*")):
            if path.suffix in _SUFFIXES and "uplot" not in path.parts and not any(map(path.is_relative_to, _OWN)):
                yield path


def words(path: Path) -> set[str]:
    """Return the names that a file uses: identifiers, and strings that are one."""
    text = path.read_text(encoding="utf-8")
    if path.suffix != ".py":
        return set(re.findall(r"\w+", _COMMENT.sub(" ", text)))
    found: set[str] = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            found.add(node.value)
        elif isinstance(node, ast.ImportFrom | ast.Import):
            paths = [getattr(node, "module", None) or "", *(alias.name for alias in node.names)]
            found.update(part for path in paths for part in path.split("."))
        else:
            named = ("id", "attr", "arg", "name")
            found.update(value for key in named if isinstance(value := getattr(node, key, None), str))
    return found


def test_code_names_no_model():
    places = {str(path.relative_to(ROOT)): sorted(words(path) & NAMES) for path in code()}
    assert {path: names for path, names in places.items() if names} == {}


def test_names_are_found_in_code_and_not_in_sentences(tmp_path):
    path = tmp_path / "some.py"
    path.write_text('"""As in the satellite."""\nfrom papers.satellite import x\ny = "sensor_lost" in x\n')
    assert words(path) & NAMES == {"satellite", "sensor_lost"}
    path.write_text('"""As in the satellite."""\nhelp = "Such as triangle."\n')
    assert not words(path) & NAMES
    header = tmp_path / "some.h"
    header.write_text("/* as the satellite's */ double sensor_lost;")
    assert words(header) & NAMES == {"sensor_lost"}
