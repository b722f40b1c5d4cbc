# SPDX-License-Identifier: Apache-2.0
"""The runs of a batch as its dataset holds them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from mehvar.runtime.batch.store.layout import NOT_RUN, STATUS

if TYPE_CHECKING:
    import xarray
    from numpy.typing import NDArray


class Recorded:
    """A dataset of a batch that reads like a store with blocks of one run.

    Parameters
    ----------
    dataset : xarray.Dataset
        Result of `mehvar.batch`.
    """

    chunk = 1
    name = "this batch"

    def __init__(self, dataset: xarray.Dataset) -> None:
        self._dataset = dataset
        self.attributes: dict[str, Any] = dict(dataset.attrs)

    @property
    def n(self) -> int:
        """Number of runs, stored or not."""
        return self._dataset.sizes["run"]

    def has(self, block: int) -> bool:
        """Return True if a run is stored."""
        return int(self._dataset[STATUS][block]) != NOT_RUN

    def runs(self, block: int) -> range:
        """Return the number of a block's run."""
        return range(block, block + 1)

    def read(self, name: str, blocks: Sequence[int] | None = None) -> NDArray[Any]:
        """Return a variable of stored runs."""
        values = self._dataset[name]
        return np.asarray(values if blocks is None else values[list(blocks)])

    def variables(self) -> Mapping[str, Any]:
        """Return the variables by name."""
        return {str(name): values for name, values in self._dataset.data_vars.items()}
