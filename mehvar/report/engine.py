# SPDX-License-Identifier: Apache-2.0
"""Engine `mehvar` of xarray, which gives opened results the accessor `.mehvar` without an import of mehvar.

xarray imports it for `open_dataset` with this engine or the default; for `open_zarr` see `accessor.Registration`.
"""

from __future__ import annotations

import os
from typing import Any, cast

import xarray
from xarray.backends import BackendEntrypoint

from mehvar.api import open_result
from mehvar.report import accessor

__all__ = ["Engine", "accessor"]


class Engine(BackendEntrypoint):
    """Engine for which `xarray.open_dataset(path, engine="mehvar")` equals `mehvar.open_result(path)`."""

    description = "Results and batches of mehvar, checked against their checksums"
    open_dataset_parameters = ("filename_or_obj", "drop_variables")

    def open_dataset(self, filename_or_obj: Any, *, drop_variables: Any = None) -> xarray.Dataset:
        """Open a result file or the store of a batch."""
        result = open_result(cast("str | os.PathLike[str]", filename_or_obj))
        return result.drop_vars(drop_variables or ())
