# SPDX-License-Identifier: Apache-2.0
"""Try mutants of the runtime, slice by slice, and write the page of survivors.

Run: python -m tests.mutants [--minutes M] [--area AREA]... [--again] [--page]
     python -m tests.mutants --sample 100 --seed K [--minutes M] [--again] [--page]

A slice goes on where the one before ended: results stand in tests/mutants/results.jsonl, one line a mutant. Which
mutants are drawn depends on the lines that they change. Ctrl-C ends a slice; what is decided stays. A sample is drawn
over whole folders instead (tests/mutants/closest.toml); its results stand in tests/mutants/sample-K.jsonl.
"""

from __future__ import annotations

import argparse
import contextlib
import sys
from collections.abc import Iterator
from itertools import zip_longest
from time import monotonic

from tests.mutants.campaign import Campaign, draw
from tests.mutants.page import reasons, write, write_sample
from tests.mutants.records import RESULTS, Mutant, Subject, sample_file, subjects
from tests.mutants.sample import sample


def main() -> None:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=float("inf"), help="stop after this time")
    parser.add_argument("--area", action="append", help="one of subjects.toml; all by default")
    parser.add_argument("--again", action="store_true", help="try those without a reason that survived once more")
    parser.add_argument("--page", action="store_true", help="only write the page")
    parser.add_argument("--sample", type=int, metavar="N", help="try N mutants of all modules, drawn by --seed")
    parser.add_argument("--seed", type=int, default=0)
    chosen = parser.parse_args()
    campaign = Campaign(sample_file(chosen.seed) if chosen.sample else RESULTS)
    if not chosen.page:
        drawn = sample(chosen.sample, chosen.seed) if chosen.sample else list(_in_turn(subjects()))
        campaign.keep({mutant.key for _, mutant in drawn})
        wanted = [(s, mutant) for s, mutant in drawn if not chosen.area or s.area in chosen.area]
        _slice(campaign, wanted, chosen.again, monotonic() + 60 * chosen.minutes)
    if chosen.sample:
        write_sample(campaign.results, chosen.sample, chosen.seed)
    else:
        write(campaign.results)


def _slice(campaign: Campaign, wanted: list[tuple[Subject, Mutant]], again: bool, end: float) -> None:
    alive = {r.key for r in campaign.results if r.outcome == "survived" and r.key not in reasons()} if again else set()
    todo = [(subject, mutant) for subject, mutant in wanted if campaign.is_open(mutant) or mutant.key in alive]
    print(f"{len(todo)} of {len(wanted)} mutants to try; Ctrl-C ends the slice", file=sys.stderr, flush=True)
    with contextlib.suppress(KeyboardInterrupt):
        for subject, mutant in todo:
            if monotonic() > end:
                break
            campaign.decide(subject, mutant)


def _in_turn(wanted: list[Subject]) -> Iterator[tuple[Subject, Mutant]]:
    """Yield mutants of all subjects in turn, so that each slice contains every subject."""
    draws = [[(subject, mutant) for mutant in draw(subject)] for subject in wanted]
    for row in zip_longest(*draws):
        yield from filter(None, row)


if __name__ == "__main__":
    main()
