# SPDX-License-Identifier: Apache-2.0
"""Editors and type checkers find every room of the house from a user's file, without a step after installation."""

import json
import subprocess
import sys
from pathlib import Path

import jedi
import pytest

ROOT = Path(__file__).parents[2]
IMPORTS = {
    "mehvar.models.system": ("System", "models/system.py"),
    "mehvar.codegen.generate": ("check", "codegen/generate.py"),
    "mehvar.runtime.model.model": ("Model", "runtime/model/model.py"),
    "mehvar.generated.triangle.triangle": ("rhs", "generated/triangle/triangle.py"),
    "mehvar.base.errors": ("MehvarError", "mehvar/base/errors.py"),
}
"""One definition of each room, and its file."""


@pytest.fixture(scope="module")
def script(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A user's file outside the repository."""
    lines = [f"from {module} import {name}" for module, (name, _) in IMPORTS.items()]
    calls = ["import mehvar", 'model = mehvar.load("triangle")', "reveal_type(model)", "wrong: str = model"]
    file = tmp_path_factory.mktemp("user") / "script.py"
    file.write_text("\n".join([*lines, *calls]) + "\n")
    return file


@pytest.mark.parametrize("number", range(len(IMPORTS)), ids=list(IMPORTS))
def test_jedi_goes_to_the_definition(script, number):
    project = jedi.Project(script.parent, environment_path=sys.prefix)
    code = script.read_text()
    (definition,) = jedi.Script(code, path=script, project=project).goto(
        number + 1, len(code.splitlines()[number]) - 1, follow_imports=True
    )
    assert definition.module_path.resolve() == ROOT / list(IMPORTS.values())[number][1]


def test_pyright_knows_the_types(script):
    """It resolves each import, infers the type of a model, and refuses a wrong use of it."""
    settings = {"pythonVersion": "3.11", "reportMissingModuleSource": False}
    (script.parent / "pyrightconfig.json").write_text(json.dumps(settings))
    check = [sys.executable, "-m", "basedpyright", "--outputjson", "--pythonpath", sys.executable, "-p", script.parent]
    done = subprocess.run(check, capture_output=True, text=True, check=False)
    notes = [note for note in json.loads(done.stdout)["generalDiagnostics"] if note["severity"] != "warning"]
    assert [(note["severity"], note["range"]["start"]["line"]) for note in notes] == [
        ("information", len(IMPORTS) + 2),
        ("error", len(IMPORTS) + 3),
    ]
    assert '"model" is "Model"' in notes[0]["message"]
