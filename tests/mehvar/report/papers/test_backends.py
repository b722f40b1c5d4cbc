# SPDX-License-Identifier: Apache-2.0
"""Our text and CasADi's own C are the same functions, and a planted difference is found."""

import hashlib
import shutil

import pytest

from mehvar.base.manifest import FILE, with_digest
from mehvar.report.papers.backends import POINTS, TOLERANCE, compare
from mehvar.reproduction.runs import Runs
from mehvar.runtime.model.catalogue import find_model, known_models
from mehvar.runtime.model.derived import folder_with
from mehvar.runtime.model.model import load
from tests.papers.shared import LIGHT, paper_agreement


@pytest.mark.parametrize(
    "model", [name if name == LIGHT else pytest.param(name, marks=pytest.mark.soak) for name in known_models()]
)
def test_every_function_is_the_same_at_random_points(model):
    found = paper_agreement(model)
    assert {function.name for function in found.functions} == set(load(model, "casadi").functions)
    for function in found.functions:
        assert function.points > POINTS / 4, function
        assert function.difference <= TOLERANCE, function
    assert found.same
    assert [run.law for run in found.runs] == list(find_model(model).controllers)
    assert all(run.ends[0] == run.ends[1] for run in found.runs)


def test_a_wrong_sign_in_casadis_text_is_found(tmp_path):
    folder = tmp_path / "triangle"
    shutil.copytree(folder_with(find_model("triangle"), "triangle_casadi.c").folder, folder)
    text = (folder / "triangle_casadi.c").read_text()
    start = text.index("/* triangle_rhs:")
    broken = text[:start] + text[start:].replace("a1=(a1+a2);", "a1=(a1-a2);", 1)
    assert broken != text
    (folder / "triangle_casadi.c").write_text(broken)
    old, new = (hashlib.sha256(content.encode()).hexdigest() for content in (text, broken))
    (folder / FILE).write_text(with_digest((folder / FILE).read_text().replace(old, new)))
    ours, theirs = load(folder, "c"), load(folder, "casadi")
    run = Runs(ours)("path", "paper")
    rhs = compare(ours, theirs, "rhs", run)
    assert not rhs.same
    assert rhs.difference > 1e-3
    assert compare(ours, theirs, "outputs", run).same
