# SPDX-License-Identifier: Apache-2.0
"""Spacecraft with what needs more than SymPy: its picture."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mehvar.models import parts

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Spacecraft(parts.Spacecraft):  # noqa: D101  # help() shows the text of its base class
    __doc__ = parts.Spacecraft.__doc__

    def draw(self, **values: float) -> Figure:
        """Draw the parts with names, places and directions, and all centres of mass, without deriving equations.

        Parameters
        ----------
        **values
            States, inputs and parameters that differ from start and defaults, as in `panel_angle=0.5`.

        Returns
        -------
        matplotlib.figure.Figure
            A figure of pyplot; a notebook shows it, and elsewhere `matplotlib.pyplot.show()`.

        Raises
        ------
        ModelError
            If a name is unknown, or the craft has no parts.
        InputError
            If matplotlib is not installed.
        """
        from mehvar.pictures.still import still_picture
        from mehvar.pictures.style import interactive_style

        with interactive_style():
            return still_picture(self.shapes(**values), [part.name for part in self.parts], self.title)
