# SPDX-License-Identifier: Apache-2.0
"""What people call from Python, with results as xarray datasets."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from runtime.model import Model
from runtime.results import to_dataset
from runtime.simulate import simulate as simulate_run

if TYPE_CHECKING:
    import xarray as xr


def simulate(
    model: Model | str | os.PathLike[str],
    controller: str,
    scenario: str | None = None,
    parameters: Mapping[str, float] | None = None,
    initial: Mapping[str, float] | None = None,
    **options: Any,
) -> xr.Dataset:
    """Integrate one closed loop.

    Parameters
    ----------
    model : str, path or Model
        Name of a model, a generated folder, or a loaded model.
    controller, scenario : str
        The law and the scenario; the model's first scenario unless given.
    parameters : mapping, optional
        Values of plant, law and scenario parameters by name.
    initial : mapping, optional
        States that start elsewhere than the scenario says.
    **options
        `t_end`, `dt_out`, `hold`, `delay`, `method`, `rtol`, `atol`, `step`, `backend`, `progress` as in
        `runtime.simulate.simulate`, or parameters by name, as in `disturbance=0.001`.

    Returns
    -------
    xarray.Dataset
        Coordinate `t`; one variable per state, input `u_NAME` and output, with units. A run that ends early returns its
        data with `status`, `reason` and `t_stop` in attrs.

    Raises
    ------
    InputError
        For anything unknown, out of bounds or infeasible.
    """
    return to_dataset(simulate_run(model, controller, scenario, parameters, initial, **options))
