# SPDX-License-Identifier: Apache-2.0
"""The Python that tests start without its imports answers as any other Python."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from mehvar.codegen.processes import in_processes
from tests import commands


def answer(program: str, code: str, folder: Path) -> tuple[int, str, str]:
    line = [program, "-P", "-c", code, "word"]
    done = subprocess.run(line, input="in", capture_output=True, text=True, cwd=folder, env={"NAME": "value"})
    return done.returncode, done.stdout, done.stderr.splitlines()[-1] if done.stderr else ""


@pytest.mark.parametrize(
    "code",
    [
        "import os, sys; print(sys.argv, sys.stdin.read(), os.getcwd(), os.environ['NAME'])",
        "raise SystemExit(3)",
        "raise SystemExit('a message')",
        "1 / 0",
        "import atexit; atexit.register(print, 'end'); import sys; sys.exit()",
        "import os; os.kill(os.getpid(), 9)",
        "import threading, time; threading.Thread(target=lambda: (time.sleep(0.1), print('late'))).start()",
    ],
)
def test_a_warm_python_answers_as_a_cold_one(code, tmp_path):
    status, *texts = answer(commands.COLD, code, tmp_path)
    if status < 0:
        status = 128 - status  # as a shell has it
    assert answer(commands.python(), code, tmp_path) == (status, *texts)


def test_it_has_imported_the_libraries_and_of_ours_no_model(tmp_path):
    code = (
        "import sys; print('sympy' in sys.modules, [name for name in sys.modules if name.startswith('mehvar.models')])"
    )
    assert answer(commands.python(), code, tmp_path)[1] == "True []\n"


def test_another_copy_of_ours_is_imported_anew(tmp_path):
    (tmp_path / "mehvar").mkdir()
    (tmp_path / "mehvar" / "__init__.py").write_text("")
    done = subprocess.run(
        [commands.python(), "-P", "-c", "import mehvar; print(mehvar.__file__)"],
        capture_output=True,
        text=True,
        check=True,
        env={"PYTHONPATH": str(tmp_path)},
    )
    assert done.stdout == f"{tmp_path}/mehvar/__init__.py\n"


def test_what_it_is_not_made_for_runs_in_another_python(tmp_path):
    script = tmp_path / "script.py"
    script.write_text("import sys; print(sys.executable, 'sympy' in sys.modules)")
    done = subprocess.run([commands.python(), script], capture_output=True, text=True, check=True)
    assert done.stdout.split()[1] == "False"


def test_the_processes_of_a_pool_start_by_it():
    assert in_processes(lambda item, pool: pool.submit(abs, item).result(), [-1, 2]) == [1, 2]
    (loaded,) = in_processes(
        lambda item, pool: pool.submit(eval, item).result(), ["'sympy' in __import__('sys').modules"]
    )
    assert loaded
