# SPDX-License-Identifier: Apache-2.0
"""A law that a reader types into a page: its numbers are those of Python, and a mistake names its place."""

import json
import re
import shutil
import subprocess
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from mehvar import html

HERE = Path(__file__).parent
FILE = Path(html.__file__).parent / "templates" / "web" / "formulas.js"
LAWS = [
    "u = 1 + 2*3 - 4/8\nv = (1 + 2)*3 - 0.5e1",
    "u = -phi^2\nv = 2^-1^2 + 2^3^2",
    "error = rho - wanted  # a part\n\nu = -k*error\nv = u*2 - --pi",
    "u = sin(t) + cos(t)*tan(rho) - tanh(phi)\nv = asin(rho) + acos(rho) + atan(phi) + atan2(-rho, phi)",
    "u = sqrt(phi) + exp(-t) + log(phi)\nv = abs(-phi) + sign(rho - wanted) + min(rho, phi)*max(t, k)",
    "u = phi - 1 - 1\nv = 8/phi/2",
    "u = .5\nv = 05 + 1.",
]
MISTAKES = {
    "u = roh\nv = 0": "line 1, column 5: roh is no name of this run; did you mean rho?",
    "u = 0\nv = k * (rho + 1": "line 2, column 17: ) must stand here, not the end of the line",
    "u = 1 +": "line 1, column 8: a number, a name or a bracket must stand here, not the end of the line",
    "u = 2 rho": "line 1, column 7: an operator must stand here, not rho",
    "u = sin rho": "line 1, column 5: sin is a function and needs brackets",
    "u = atan2(1)": "line 1, column 5: atan2 takes two numbers, not 1",
    "u = sni(1)": "line 1, column 5: sni is no function; did you mean sin?",
    "u = 1; alert(1)": "line 1, column 6: an operator must stand here, not ;",
    "u = constructor": "line 1, column 5: constructor is no name of this run",
    "u = 1e999": "line 1, column 5: 1e999 is too large a number",
    "rho = 1": "line 1, column 1: rho has a value already; choose another name",
    "u = 0\nu = 1": "line 2, column 1: u has a value already; choose another name",
    "sin = 0": "line 1, column 1: sin is a function; choose another name",
    "7": "line 1, column 1: a line begins with a name, as in u = 0, not with 7",
    "u = 0": "a line v = ... is missing; every input needs one",
    f"u = {'(' * 2000}": "line 1, column 105: more than 100 brackets within brackets",
    f"u = {'2^' * 1500}2": "line 1, column 205: more than 100 powers of powers",
    f"u = {'1+' * 3000}1": "my law has 6005 letters; at most 4000 are read",
}


@pytest.fixture(scope="module")
def answers():
    """The answer of the page's parser to each text."""
    program = shutil.which("node")
    if program is None:
        pytest.skip("no Node: apt install nodejs")
    texts = [*LAWS, *MISTAKES]
    command = [program, HERE / "formulas.mjs", FILE, json.dumps(texts)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return dict(zip(texts, json.loads(done.stdout), strict=True))


def test_numbers_are_those_of_the_same_law_in_python(answers):
    for text in LAWS:
        given = {"np": np, "x": SimpleNamespace(rho=0.5, phi=3.0, wanted=1.0), "t": 2.0, "k": 4.0}
        exec("\n".join(answers[text]["python"]), given)
        assert answers[text]["inputs"] == pytest.approx([given["u_"], given["v_"]], rel=1e-14)


def test_a_mistake_names_its_place(answers):
    for text, message in MISTAKES.items():
        assert answers[text]["mistake"].startswith("my law")
        assert answers[text]["mistake"].endswith(message)


def test_no_text_becomes_a_script():
    assert re.findall(r"\b(?:eval|Function|import|setTimeout)\s*\(", FILE.read_text(encoding="utf-8")) == []
