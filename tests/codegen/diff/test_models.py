# SPDX-License-Identifier: Apache-2.0
"""The three models against themselves, against edits of single terms, and against rewritten texts."""

import dataclasses
import random
import subprocess
import sys

import pytest

from mehvar.codegen.diff import Document, compare
from mehvar.codegen.diff.changes import Change
from mehvar.codegen.diff.report import EquationVerdict, Kind
from mehvar.codegen.equations.formula import Printer
from mehvar.codegen.generate import installed_tree
from tests.codegen.diff.documents import at, edited, flipped, summands

GENERATED = installed_tree().root / "generated"
MODELS = ("triangle", "slosh", "satellite")


@pytest.fixture(scope="module", params=MODELS)
def model(request):
    return Document.read(GENERATED / request.param)


def test_a_model_is_the_same_as_itself(model):
    comparison = compare(model, model)
    assert {equation.verdict for equation in comparison} == {EquationVerdict.SAME}
    assert {equation.how for equation in comparison} == {"node identity"}
    assert not comparison.differs


@pytest.mark.share(3)
def test_an_edit_of_any_term_is_found_where_it_was_made(model):
    """Four definitions, a sign each; what does not depend on it stays the same."""
    generator = random.Random(2025)
    rows = [row for row in model.definitions if row.named and summands(model.nodes, row.node)]
    for row in generator.sample(rows, 4):
        node, path = generator.choice(summands(model.nodes, row.node))
        comparison = compare(model, flipped(model, row, path))
        assert [equation.name for equation in comparison.sources] == [row.name], Printer(model.nodes).text(node)
        assert len(comparison[row.name].edits) == 1
        assert comparison[row.name].replayed
        assert not comparison.of(EquationVerdict.UNDECIDED)
        users = set(comparison[row.name].users)
        assert {equation.name for equation in comparison if equation.verdict is EquationVerdict.INHERITED} == users


def test_a_flipped_coriolis_sign_of_the_slosh_model_is_what_it_points_at():
    model = Document.read(GENERATED / "slosh")
    row = next(row for row in model.definitions if row.number == "(12)" and row.kind == "equation")
    terms = {Printer(model.nodes).text(node): path for node, path in summands(model.nodes, row.node)}
    text = next(text for text in terms if "theta_dot" in text or r"\dot{\theta}" in text)
    comparison = compare(model, flipped(model, row, terms[text]))
    (source,) = comparison.sources
    (edit,) = source.edits
    assert (source.number, edit.kind) == ("(12)", Kind.SIGN)
    assert edit.old.places == (terms[text],)
    assert comparison.counts()["same"] == len(comparison.equations) - 1


def test_the_same_sign_for_every_pendulum_is_one_story():
    model = Document.read(GENERATED / "slosh")
    new = model
    for name in ("k_phi1", "k_phi2"):
        row = next(row for row in new.definitions if row.name == name)
        _, path = min(summands(new.nodes, row.node), key=lambda s: (len(s[1]), Printer(new.nodes).text(s[0])[::-1]))
        new = flipped(new, row, path)
    comparison = compare(model, new)
    assert {equation.name for equation in comparison.sources} == {"k_phi1", "k_phi2"}
    (group,) = comparison.groups
    assert group.kind == "family"
    assert group.names == ("k_phi1", "k_phi2")


@pytest.mark.share(3)
def test_inlining_definitions_changes_nothing(model):
    """Half of the definitions are written out wherever they are used."""
    new = model
    for row in [row for row in model.definitions if row.named][::2]:
        new = _inlined(new, row.name)
    comparison = compare(model, new)
    assert not comparison.differs, [(e.name, e.verdict, e.how) for e in comparison if e.matters][:5]


def _inlined(model, name):
    meaning = model.named[name]
    nodes = list(model.nodes)
    for k, node in enumerate(nodes):
        if node == ("sym", name):
            nodes[k] = nodes[meaning.node]
    order = {}
    reached = []

    def move(k):
        if k not in order:
            operation, *operands = nodes[k]
            row = (operation, *(move(o) if isinstance(o, int) else o for o in operands))
            order[k] = len(reached)
            reached.append(row)
        return order[k]

    rows = [row for row in model.rows if row is not meaning]
    moved = [dataclasses.replace(row, node=move(row.node)) for row in rows]
    count = len(model.definitions) - 1
    return dataclasses.replace(
        model, nodes=tuple(reached), definitions=tuple(moved[:count]), results=tuple(moved[count:])
    )


def test_a_lost_branch_of_the_law_is_found():
    """The path law of the triangle without its outermost saturation."""
    model = Document.read(GENERATED / "triangle")
    row = model.named["phi_t_rate"]
    node, path = row.node, ()
    while model.nodes[node][0] != "max":
        k = next(k for k, o in enumerate(model.nodes[node][1:]) if _holds(model, o, "max"))
        node, path = model.nodes[node][1 + k], (*path, k)

    def without(pool, root):
        inner = next(o for o in pool.operands(at(pool, root, path)) if pool.nodes[o][0] == "min")
        return Change(Kind.REWRITTEN, path, inner, inner, inner, "", 0.0)

    new = edited(model, row, without)
    comparison = compare(model, new)
    assert [equation.name for equation in comparison.sources] == ["phi_t_rate"]
    assert comparison["phi_t_rate"].replayed


def _holds(model, node, operation):
    return any(model.nodes[k][0] == operation for k in model.reached(node))


def test_comparing_imports_neither_sympy_nor_casadi():
    code = (
        "import sys; from mehvar.codegen.diff import compare, Document\n"
        f"d = Document.read({str(GENERATED / 'triangle')!r}); compare(d, d)\n"
        "print([m for m in ('sympy', 'casadi', 'numpy') if m in sys.modules])"
    )
    reached = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert reached.stdout.strip() == "[]"
