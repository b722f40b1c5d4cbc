# SPDX-License-Identifier: Apache-2.0
"""Output in a notebook: from committed files, escaped, and formulas that a typesetter takes."""

from __future__ import annotations

import re
import subprocess
import sys
from dataclasses import replace

import pytest
import sympy as sp

import mehvar
from mehvar.codegen.equations.mathml import mathml
from mehvar.models.system import Controller, Function, Group, Parameter, Quantity
from mehvar.runtime.model.equations import rates
from tests.docs.formulas import faults


def formulas(text: str) -> list[str]:
    return [tex.replace("{gathered}", "{aligned}") for tex in re.findall(r"\$\$(.*?)\$\$", text, re.DOTALL)]


@pytest.mark.parametrize("name", mehvar.list_models())
def test_a_model_shows_its_names_and_a_formula_for_each_state(name):
    model = mehvar.load(name, "python")
    page = model._repr_html_()
    for q in (*model.manifest.states, *model.manifest.parameters):
        assert f"<td>{q.name}</td>" in page
    assert len(rates(model.manifest)) == len(model.state_names)
    (block,) = formulas(model._repr_latex_())
    assert block in page.replace("{gathered}", "{aligned}")
    assert not list(faults(mathml(block)))
    assert "path" in mehvar.load("triangle", "python").functions._ipython_key_completions_()


def test_a_model_is_shown_without_derivation():
    code = (
        "import sys\nfor name in ('sympy', 'casadi', 'jinja2', 'latex2mathml'): sys.modules[name] = None\n"
        "import mehvar; assert len(mehvar.load('slosh', 'python')._repr_html_()) > 5000"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_laws_scenarios_and_functions_are_tables():
    manifest = mehvar.load("triangle", "python").manifest
    assert "<td>k_phi*R/m</td>" in manifest.controllers["sliding"]._repr_html_()
    assert "<td>k_phi</td><td>5</td><td>path</td>" in manifest.scenarios["printed"]._repr_html_()
    assert "<td>rho</td><td>argument</td><td>number</td>" in mehvar.load("triangle").functions["lengths"]._repr_html_()


def test_texts_are_escaped():
    scenario = mehvar.load("triangle", "python").manifest.scenarios["paper"]
    assert "<b>" not in replace(scenario, title="<b>&")._repr_html_()


def test_a_group_shows_its_quantities():
    group = Group("p", (Quantity("l", "m", "length & more"), Parameter("k", "N", "gain", default=2.0, bounds="(0, 9]")))
    assert repr(group) == "<group p: l [m], k [N]>"
    assert "<td>length &amp; more</td>" in group._repr_html_()
    assert "<td>2.0</td><td>(0, 9]</td>" in group._repr_html_()


def test_vectors_and_linear_systems_show_their_names():
    model = mehvar.load("satellite", "python")
    assert repr(model.state(roll=0.5)).startswith("NamedVector(roll=0.5, pitch=0, ")
    system = model.linearize(model.state())
    assert repr(system).startswith("<linear system, continuous: states roll, pitch, ")
    assert "<caption>B</caption><thead><tr><th></th><th>Tx</th>" in system._repr_html_()


def test_a_number_in_a_name_is_an_index():
    """I_1 is I with the index 1."""
    quantity = Quantity("I_1", "kg m^2", "inertia")
    law = Controller("law", "a law", Group("p", (quantity,)), (2 * quantity.symbol,))
    assert law._repr_latex_() == r"$$\begin{gathered} u_{1} = 2 I_{1} \end{gathered}$$"
    assert "<msub><mi>I</mi><mn>1</mn></msub>" in re.sub(r"</?mrow>", "", mathml("I_{1}"))


def test_symbolic_functions_and_laws_are_formulas():
    length, rate = Quantity("l", "m", "length", r"\ell"), Quantity("v", "m/s", "rate", r"\dot\ell")
    group = Group("p", (length,))
    law = Controller("law", "a law", group, (2 * length.symbol,))
    function = Function("speed", (group,), ((rate, sp.sqrt(length.symbol)),), "speed")
    assert law._repr_latex_() == r"$$\begin{gathered} u_{1} = 2 \ell \end{gathered}$$"
    assert function._repr_latex_() == r"$$\begin{gathered} \dot\ell = \sqrt{\ell} \end{gathered}$$"
