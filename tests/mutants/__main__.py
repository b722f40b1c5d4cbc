# SPDX-License-Identifier: Apache-2.0
"""Try mutants of the runtime, slice by slice, and write the page of what survived.

Run: python -m tests.mutants [--minutes M] [--area AREA]... [--page]

A slice goes on where the one before ended: results stand in build/mutants/results.jsonl, one line a mutant. Which
mutants are drawn depends on the text of a module alone.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from itertools import zip_longest
from time import monotonic

from tests.mutants.campaign import Campaign, Mutant, Subject, draw, subjects
from tests.mutants.page import write


def main() -> None:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=float("inf"), help="stop after so many")
    parser.add_argument("--area", action="append", help="one of subjects.toml; all by default")
    parser.add_argument("--page", action="store_true", help="only write the page")
    chosen = parser.parse_args()
    campaign, end = Campaign(), monotonic() + 60 * chosen.minutes
    for python in () if chosen.page else (True, False):
        # Python first: a process that has loaded the tree for the sake of C cannot part into one without it
        wanted = [s for s in subjects() if s.python == python and (not chosen.area or s.area in chosen.area)]
        for subject, mutant in _in_turn(wanted):
            if monotonic() > end:
                break
            campaign.decide(subject, mutant)
    write(campaign.results())


def _in_turn(wanted: list[Subject]) -> Iterator[tuple[Subject, Mutant]]:
    """Yield a mutant of each subject, then the next of each: a slice has something of all."""
    draws = [[(subject, mutant) for mutant in draw(subject)] for subject in wanted]
    for row in zip_longest(*draws):
        yield from filter(None, row)


if __name__ == "__main__":
    main()
