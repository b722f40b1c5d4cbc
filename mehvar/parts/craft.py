# SPDX-License-Identifier: Apache-2.0
"""Spacecraft with what needs more than SymPy: its picture, and the gates of its physics."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mehvar.models import parts
from mehvar.models.quantities import ModelError

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Spacecraft(parts.Spacecraft):  # noqa: D101  # help() shows the text of its base class
    __doc__ = parts.Spacecraft.__doc__

    def check(self) -> dict[str, float]:
        """Check the laws of mechanics at random states; wrong aggregates of own parts break them.

        Energy changes by the power of loads, motors and dampers; momentum changes by the loads; the order of parts and
        a constant velocity have no effect. For each part: the momentum is the rate of the first moment, the speed of a
        particle is that of its place, kinetic energy is never negative, the inertia is that of a body, dampers take
        energy.

        Returns
        -------
        dict of str to float
            The error of each law, relative to the size of its terms.

        Raises
        ------
        ModelError
            If a law is broken, or the craft cannot be built.
        """
        from mehvar.physics.gates import TOLERANCE

        from .gates import gates

        result = gates(self)
        broken = [f"{law} (error {error:.2g})" for law, error in result.items() if not error <= TOLERANCE]
        if broken:
            raise ModelError(f"{self.name}: not true: {'; '.join(broken)}; at most {TOLERANCE:g}")
        return result

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
