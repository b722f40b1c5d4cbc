# SPDX-License-Identifier: Apache-2.0
"""Operations of the shipped right-hand sides beside those assembled from parts, with the verdict on their equality.

python -m benchmarks.from_parts
"""

from __future__ import annotations

import itertools
import sys

from benchmarks.machine import RESULTS, command_line, machine, table, write
from mehvar.models.satellite import STRUCTURE as SATELLITE
from mehvar.models.triangle import STRUCTURE as TRIANGLE

sys.path.insert(0, str(RESULTS.parents[1]))
from tests.models.parts.shipped import satellite, slosh, triangle
from tests.models.parts.shipped.rederived import Pair, operations

PENDULUMS = ("2", "8")


def row(name: str, pair: Pair, rhs: str = "rhs") -> list[str]:
    """Return structure, operations of the shipped and of the assembled form, their ratio, and the verdict."""
    shipped, assembled = operations(pair.shipped.system, rhs), operations(pair.assembled.system)
    differences = pair.differences()
    return [name, str(shipped), str(assembled), f"{assembled / shipped:.2f}", ", ".join(differences) or "same"]


def main() -> None:
    """Count and write the page."""
    command_line(__doc__).parse_args()
    rows = []
    for count, inertia in itertools.product(PENDULUMS, slosh.PENDULUMS):
        pairs = slosh.forms(count, inertia, "quaternion")
        parts = ("", ", on universal joints")[: len(pairs)]
        rows += [row(f"slosh {count} {inertia}{part}", pair) for part, pair in zip(parts, pairs, strict=True)]
    for choices in itertools.product(*SATELLITE.values()):
        rows.append(row(f"satellite {' '.join(choices)}", satellite.forms(*choices)))
    for choices in itertools.product(TRIANGLE["masses"], TRIANGLE["rods"]):
        rows.append(row(f"triangle {' '.join(choices)}", triangle.forms(*choices)))
    write(
        "from_parts.md",
        [
            "# The shipped systems from library parts",
            "",
            "Written by `python -m benchmarks.from_parts`. Operations of a right-hand side that depend on state",
            "or input. Slosh and satellite have parts of their own. The verdict is that of `mehvar diff` in a",
            "finite field; `make soak` compares slosh with 1, 2, 3, 8 and 64 pendulums, up to three by `mehvar",
            "diff` itself with laws, and every satellite and triangle. The satellite from library parts moves on",
            "its orbit in inertial axes, and receives the torques of air, light and dipole, which the shipped",
            "computes. The triangle, of which the library has no part, has places of masses as states in place of",
            "lengths, and counts neither work nor impulse.",
            "",
            *machine(),
            "",
            *table(("structure", "shipped", "from library parts", "ratio", "verdict"), rows),
        ],
    )


if __name__ == "__main__":
    main()
