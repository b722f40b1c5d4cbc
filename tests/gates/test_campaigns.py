# SPDX-License-Identifier: Apache-2.0
"""Every campaign of the Makefile is recorded, and the page says what the records say."""

from __future__ import annotations

import ast
import importlib
import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests import campaigns

ROOT = Path(__file__).parents[2]


def test_every_campaign_of_the_makefile_is_on_the_page() -> None:
    text = (ROOT / "Makefile").read_text(encoding="utf-8")
    listed = re.search(r"^CAMPAIGNS := (.*)$", text, re.MULTILINE)
    assert listed is not None
    assert set(listed[1].split()) == campaigns.CAMPAIGNS.keys()
    assert all(f"\ncampaign-{name}:" in text for name in campaigns.CAMPAIGNS)


def test_the_page_says_what_the_records_say() -> None:
    text = campaigns.PAGE.read_text(encoding="utf-8")
    assert campaigns.page(text) == text


def test_a_campaign_that_fails_is_recorded_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("RECORDS", "PAGE"):
        copy = tmp_path / name
        copy.write_bytes(getattr(campaigns, name).read_bytes())
        monkeypatch.setattr(campaigns, name, copy)
    assert campaigns.main("peers", sys.executable, "-c", "raise SystemExit(3)") == 3
    result = json.loads((tmp_path / "RECORDS").read_text())["peers"]
    assert result["outcome"] == "failed, exit 3"
    assert result["commit"]
    assert "| failed, exit 3 | 0 |" in (tmp_path / "PAGE").read_text()
    assert campaigns.main("peers", sys.executable, "-c", "") == 0
    assert "| passed | 0 |" in (tmp_path / "PAGE").read_text()


def test_the_row_of_another_campaign_is_no_change_of_the_commit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("campaigns.json", "campaigns.md", "other.py"):
        (tmp_path / name).touch()
    git = ("git", "-C", str(tmp_path), "-c", "user.name=a", "-c", "user.email=a")
    for words in (("init", "-q"), ("add", "."), ("commit", "-q", "-m", "first")):
        subprocess.run([*git, *words], check=True)
    monkeypatch.setattr(campaigns, "ROOT", tmp_path)
    (tmp_path / "campaigns.json").write_text("{}")
    assert "with changes" not in campaigns.commit()
    (tmp_path / "other.py").write_text("1")
    assert campaigns.commit().endswith("with changes")


def test_the_tests_that_other_pythons_run_exist() -> None:
    text = (ROOT / "tests" / "gates" / "matrix.py").read_text(encoding="utf-8")
    files = re.findall(r'"(tests/[\w/]+\.py)"', text)
    assert len(files) > 5
    assert [name for name in files if not (ROOT / name).is_file()] == []


@pytest.mark.parametrize("folder", ["benchmarks", "tests/validation"])
def test_a_campaign_imports_only_names_of_ours_that_are_there(folder: str) -> None:
    """The suite cannot import these files, whose engines are not installed; a renamed helper would stop a campaign."""
    missing = []
    for path in sorted((ROOT / folder).rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if not isinstance(node, ast.ImportFrom) or not re.match(r"(mehvar|tests)\b", node.module or ""):
                continue
            assert node.module is not None
            if "validation.against" in node.module:  # imports an engine itself
                continue
            missing += [
                f"{path.name}: {node.module}.{a.name}" for a in node.names if not _is_there(node.module, a.name)
            ]
    assert not missing


def _is_there(module: str, name: str) -> bool:
    try:
        return hasattr(importlib.import_module(module), name) or bool(importlib.import_module(f"{module}.{name}"))
    except ImportError:
        return False
