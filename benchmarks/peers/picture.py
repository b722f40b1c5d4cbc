# SPDX-License-Identifier: Apache-2.0
"""The work-precision picture."""

from __future__ import annotations

from pathlib import Path
from typing import Any

STYLES = {
    "mehvar dop853, fast": ("#000000", "o", "mehvar dop853, fast"),
    "mehvar dop853, portable": ("#0072B2", "s", "mehvar dop853, portable"),
    "mehvar dopri5, portable": ("#56B4E9", "^", "mehvar dopri5, portable"),
    "heyoka taylor batch, compact_mode=False": ("#D55E00", "D", "heyoka, batch"),
    "scipy LSODA, numba right-hand side": ("#009E73", "v", "scipy LSODA, numba"),
    "casadi cvodes, compiled right-hand side": ("#CC79A7", "P", "casadi cvodes, compiled"),
    "diffrax Dopri8": ("#E69F00", "X", "diffrax Dopri8"),
}
"""Colours of Okabe and Ito, and and a marker for each, so that the picture can be read without colour."""
FLOOR = 1e-15  # smaller errors are drawn here


def picture(record: dict[str, Any], path: Path) -> None:
    """Draw time per run over error, one panel for each case."""
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, len(record), figsize=(4.2 * len(record), 4.6), sharey=False, squeeze=False)
    for axis, entry in zip(axes[0], record.values(), strict=True):
        for name, (colour, marker, label) in STYLES.items():
            rows = sorted((max(r["error"], FLOOR), r["seconds"] * 1e6) for r in entry["rows"] if r["name"] == name)
            if rows:
                axis.plot(*zip(*rows, strict=True), color=colour, marker=marker, markersize=5, label=label)
        axis.set(xscale="log", yscale="log", title=entry["title"], xlim=(1e-4, FLOOR / 3))
        axis.set(xlabel="median relative error at the end [1]", ylabel="processor time per run [µs]")
        axis.grid(True, which="major", alpha=0.3)
    handles, labels = axes[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncols=4, frameon=False)
    figure.tight_layout(rect=(0, 0.12, 1, 1))
    figure.savefig(path, dpi=110)
    plt.close(figure)
