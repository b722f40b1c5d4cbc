# SPDX-License-Identifier: Apache-2.0
"""Runs of a batch in its dataset."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from .layout import NOT_RUN, STATUS, Coordinate, Runs, Variable

if TYPE_CHECKING:
    import xarray
    from numpy.typing import NDArray

    from .store import Store

Batch: TypeAlias = "Store | DatasetBatch"
"""Recorded runs of a batch."""


class DatasetBatch(Runs):
    """Runs of a batch in its dataset.

    Parameters
    ----------
    dataset : xarray.Dataset
        Result of `mehvar.batch`.
    chunk : int
        Runs of a block.
    """

    name = "this batch"

    def __init__(self, dataset: xarray.Dataset, chunk: int = 1) -> None:
        self._dataset, self.chunk, self.n = dataset, chunk, dataset.sizes["run"]
        self.attributes: dict[str, Any] = dict(dataset.attrs)

    @property
    def width(self) -> int:
        """Number of runs that were computed together; all of a dataset that no longer states its chunks."""
        chunks: Mapping[str, int] = self._dataset[STATUS].encoding.get("preferred_chunks", {})
        return min(chunks.get("run", self.n), self.n)

    def has(self, block: int) -> bool:
        """Return True if a run of a block is stored."""
        return bool((self.read(STATUS, [block]) != NOT_RUN).any())

    def read(self, name: str, blocks: Sequence[int] | None = None) -> NDArray[Any]:
        """Return a variable of the runs of some blocks; default: of all."""
        return np.array(self._of(name, blocks))

    def series(self, name: str, first: int, last: int, blocks: Sequence[int]) -> NDArray[np.float64]:
        """Return samples first ... last - 1 of a stored series, shape (runs, samples)."""
        return np.array(self._of(name, blocks)[:, first:last])

    def variables(self) -> Mapping[str, Variable]:
        """Return the variables by name."""
        return {
            str(name): Variable(
                str(name), str(values.dtype), "".join(map(str, values.dims[1:])), sum(values.shape[1:]), values.attrs
            )
            for name, values in self._dataset.data_vars.items()
        }

    def coordinate(self, name: str) -> Coordinate:
        """Return the coordinate of a second dimension, empty if the batch has none."""
        if name not in self._dataset.variables:
            return Coordinate([])
        return Coordinate(np.array(self._dataset[name]), self._dataset[name].attrs)

    def _of(self, name: str, blocks: Sequence[int] | None) -> xarray.DataArray:
        values = self._dataset[name]
        return values if blocks is None else values[[run for block in blocks for run in self.runs(block)]]
