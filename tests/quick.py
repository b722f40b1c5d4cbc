# SPDX-License-Identifier: Apache-2.0
"""Run the tests of files that changed since `main`, and the gates of names and layout, in a minute.

Tests stand where their subject stands: `runtime/run/ticks.py` has `tests/runtime/run/test_ticks.py`. A file without a
test of its name has the tests of its folder, or of the nearest folder above it. After 50 s no further test begins.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Iterable
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
GATES = ("tests/gates/test_names.py", "tests/gates/test_rooms.py", "tests/gates/test_public.py")
SECONDS = 50
"""Time after which no further test starts, s, so that the run ends within a minute."""
PAGES = "tests/docs/test_docs.py"
MARKS = "not peers and (page or not soak)"
OF_A_PAGE = ("test_links_lead_somewhere", "test_what_a_page_shows_runs")


def changed() -> list[str]:
    """Return the files that changed since the branch left `main`, including new files."""
    base = _git("merge-base", "HEAD", "main") or ["HEAD"]
    return sorted({*_git("diff", "--name-only", *base), *_git("ls-files", "--others", "--exclude-standard")})


def near(files: Iterable[str]) -> list[str]:
    """Return the arguments of pytest: the tests of each file, those of its name before those of its folder."""
    own, others = list[str](), list[str]()
    for file in files:
        path = Path(file)
        if path.suffix == ".md":
            own += [f"{PAGES}::{test}[{file}]" for test in OF_A_PAGE if (ROOT / path).is_file()]
        elif path.parts[0] == "tests" and path.name.startswith("test_"):
            own += [file] * (ROOT / path).is_file()
        elif (mirror := _mirror(path.parent) / f"test_{path.stem}.py").is_file():
            own.append(mirror.relative_to(ROOT).as_posix())
        else:
            others += _around(path.parent)
    return list(dict.fromkeys([*own, *others, *GATES]))


def _mirror(folder: Path) -> Path:
    return ROOT / folder if folder.parts[:1] == ("tests",) else ROOT / "tests" / folder


def _around(folder: Path) -> list[str]:
    """Return the tests of the nearest folder that has some; none for files at the top of the repository."""
    for place in (folder, *folder.parents)[:-1]:
        if found := sorted(_mirror(place).glob("test_*.py")):
            return [path.relative_to(ROOT).as_posix() for path in found]
    return []


def _git(*arguments: str) -> list[str]:
    done = subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True, check=False)
    return done.stdout.splitlines()


class Minute:
    """Keep the order of the command line; start no test after the time limit."""

    def __init__(self, seconds: float = SECONDS) -> None:
        self._end = time.monotonic() + seconds

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, config: pytest.Config, items: list[pytest.Item]) -> None:
        order = [argument.split("::")[0] for argument in config.args]
        items.sort(key=lambda item: order.index(item.nodeid.split("::")[0]))

    def pytest_runtest_teardown(self, item: pytest.Item) -> None:
        if time.monotonic() > self._end:
            item.session.shouldstop = "the minute is over; the tests that are left are undecided: run `make test`"


def main() -> int:
    """Run the tests."""
    os.chdir(ROOT)
    os.environ.setdefault("MEHVAR_TEST_CACHE", "build/cache")
    return int(pytest.main(["--import-mode=importlib", "-m", MARKS, *near(changed())], plugins=[Minute()]))


if __name__ == "__main__":
    sys.exit(main())
