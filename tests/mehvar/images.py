# SPDX-License-Identifier: Apache-2.0
"""Checks of every figure of a paper."""


def numbered_and_told(figures, numbers):
    return [figure.number for figure in figures] == list(numbers) and all(
        figure.title and len(figure.caption) > 80 for figure in figures
    )


def unlabelled(figure):
    """Return labels of axes without a unit, and empty axes."""
    wrong = [ax for ax in figure.axes if not ax.has_data()]
    for ax in figure.axes:
        axes = [ax.xaxis, ax.yaxis, *([ax.zaxis] if hasattr(ax, "zaxis") else [])]
        labels = [axis.get_label_text() for axis in axes]
        wrong += [text for text in labels if not (text.endswith("]") and "[" in text)]
    return wrong
