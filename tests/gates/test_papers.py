# SPDX-License-Identifier: Apache-2.0
"""The papers use what anyone can: public names of mehvar, and of the model that a paper is about."""

from __future__ import annotations

import ast
import importlib
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PUBLIC = ("mehvar", *(f"mehvar.{m}" for m in ("ledger", "mechanics", "parts", "pictures", "reproduction", "runtime")))
"""Modules whose `__all__` is documented in docs/reference/python.md."""
MODULES = sorted((ROOT / "papers").rglob("*.py"))


def name_of(path: Path) -> str:
    """Return the path in the repository, which names a test."""
    return str(path.relative_to(ROOT))


def private(path: Path, root: Path = ROOT) -> Iterator[str]:
    """Yield the imports of a module of papers/MODEL that are not public, or lead out of its folder."""
    parts = path.relative_to(root / "papers").parts
    own = f"mehvar.models.{parts[0]}"
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (
                a.name for a in node.names if a.name.split(".")[0] in ("mehvar", "papers") and a.name != "mehvar"
            )
        elif isinstance(node, ast.ImportFrom):
            module = "." * node.level + (node.module or "")
            if node.level >= len(parts) or module.split(".")[0] == "papers":
                yield module
            elif module in PUBLIC:
                yield from (f"{module}.{a.name}" for a in node.names if a.name not in exported(module))
            elif f"{module}.".startswith(f"{own}."):
                yield from (f"{module}.{a.name}" for a in node.names if f".{module}.{a.name}".count("._"))
            elif module.split(".")[0] == "mehvar":
                yield module
        elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "mehvar":
            yield from () if node.attr in exported("mehvar") else (f"mehvar.{node.attr}",)


def exported(module: str) -> list[str]:
    """Return the public names of a module."""
    names: list[str] = importlib.import_module(module).__all__
    return names


@pytest.mark.parametrize("path", MODULES, ids=name_of)
def test_a_paper_takes_public_names_only(path: Path) -> None:
    assert list(private(path)) == []


def test_what_is_private_is_named(tmp_path: Path) -> None:
    path = tmp_path / "papers" / "cart" / "ledger.py"
    path.parent.mkdir(parents=True)
    path.write_text(
        "import mehvar, numpy\nimport mehvar.runtime.run.options\n"
        "from papers.slosh import rows\nfrom ..slosh import rows\nfrom .symbols import Z\n"
        "from mehvar.ledger import Names, Meanings\nfrom mehvar.models.cart.dynamics import X, _Y\n"
        "from mehvar.models.slosh.states import rate\nmehvar.simulate, mehvar.api\n"
    )
    assert sorted(private(path, tmp_path)) == [
        "..slosh", "mehvar.api", "mehvar.ledger.Meanings", "mehvar.models.cart.dynamics._Y",
        "mehvar.models.slosh.states", "mehvar.runtime.run.options", "papers.slosh",
    ]  # fmt: skip


def test_the_product_is_documented_where_papers_take_it_from() -> None:
    page = (ROOT / "docs" / "reference" / "python.md").read_text(encoding="utf-8")
    assert [module for module in PUBLIC if f"`{module}`" not in page] == []
