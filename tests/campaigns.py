# SPDX-License-Identifier: Apache-2.0
"""Run the campaigns outside the suite, and record their outcomes.

python -m tests.campaigns NAME COMMAND...    run a campaign, and write its record and the page
python -m tests.campaigns                    write the page

`make NAME` does the first. The exit status is the command's.
"""

from __future__ import annotations

import datetime
import json
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).parents[1]
RECORDS = Path(__file__).with_name("campaigns.json")
PAGE = ROOT / "docs" / "reference" / "campaigns.md"
CAMPAIGNS = {
    "validate": "models, integrator and statistics against engines of others",
    "mutants": "wrong versions of the runtime, each of which a test should notice",
    "soak": "fuzzing, a day of samples, kills, interrupts, ten million runs: hours",
    "matrix": "other Pythons, the oldest and the newest libraries",
    "peers": "the tools that models are exported to: FMPy, JAX, Numba, python-control, Polars",
    "compare": "one task in other tools",
    "sceptic": "the claims of speed",
}
_START = "<!-- table: written by python -m tests.campaigns -->\n"


def main(name: str = "", *command: str) -> int:
    """Run a campaign, if there is one to run, and write the page."""
    status = 0
    if name:
        begin, about = time.monotonic(), {"date": str(datetime.date.today()), "commit": commit()}
        status = subprocess.run(command, cwd=ROOT, check=False).returncode
        outcome = "passed" if status == 0 else f"failed, exit {status}"
        record(name, {**about, "outcome": outcome, "minutes": str(round((time.monotonic() - begin) / 60))})
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
    return status


def record(name: str, result: dict[str, str]) -> None:
    """Replace the record of a campaign by the new one."""
    assert name in CAMPAIGNS, name
    records = {**json.loads(RECORDS.read_text(encoding="utf-8")), name: result}
    RECORDS.write_text(json.dumps(records, indent=1, sort_keys=True) + "\n", encoding="utf-8")


def commit() -> str:
    """Return the commit of the checkout, and whether it has changes besides."""

    def git(*words: str) -> str:
        return subprocess.run(["git", *words], cwd=ROOT, capture_output=True, text=True, check=True).stdout.strip()

    own = [f":(exclude,glob)**/{path.name}" for path in (RECORDS, PAGE)]  # of which the campaign before wrote its row
    changed = git("status", "--porcelain", "--", ".", *own)
    return git("rev-parse", "--short", "HEAD") + (" with changes" if changed else "")


def page(text: str) -> str:
    """Return the page with the table of the records."""
    records = json.loads(RECORDS.read_text(encoding="utf-8"))
    rows = ["| command | what | last run | commit | outcome | minutes |", "|---|---|---|---|---|---|"]
    for name, what in CAMPAIGNS.items():
        r = records.get(name, {})
        last = " | ".join(r.get(key, "") for key in ("date", "commit", "outcome", "minutes"))
        rows.append(f"| `make {name}` | {what} | {last if r else 'not recorded | | |'} |")
    head, _, _ = text.partition(_START)
    return head + _START + "\n" + "\n".join(rows) + "\n"


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
