# SPDX-License-Identifier: Apache-2.0
"""Accessor `.mehvar` of results: `run.mehvar.plot()`, `.metrics()`, `.compare(other)`, `.report(path)`.

Importing this module registers the accessor with xarray. `mehvar.simulate`, `batch` and `open_result` import it, and
so does xarray when it opens a file or a store; see `Engine` and `Registration`.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from numbers import Integral
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mehvar.base.display import frame
from mehvar.base.errors import InputError, MehvarError, MissingError, bad_value, unknown_name
from mehvar.base.manifest import FILE, Manifest, parse_manifest
from mehvar.runtime.files import checked_ending, write_atomic
from mehvar.runtime.model.catalogue import known_models
from mehvar.runtime.run.metrics import metrics, metrics_of

try:
    import xarray
except ImportError as error:
    raise MissingError("results are datasets of xarray: pip install xarray") from error

if TYPE_CHECKING:
    import pandas
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from mehvar.pictures.spread import Runs
    from mehvar.report.page import Page
    from mehvar.runtime.model.model import Model
    from mehvar.runtime.run.user.inputs import Interpolation
    from mehvar.runtime.run.user.law import LawFunction

_HEIGHT = 720
"""Height of an animation in a notebook, pixels: picture, plots and controls fit on a laptop's screen."""
_OF_RUN = "plot metrics compare animate report"
"""Methods for the result of a single run."""


@dataclass(frozen=True)
class Animation:
    """An animation as a page that runs in any browser, without a network."""

    page: str

    def __repr__(self) -> str:
        return f"<mehvar animation, {len(self.page) / 1e6:.1f} MB; save(path) writes it>"

    def _repr_html_(self) -> str:
        return frame(self.page, _HEIGHT)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the page, whose name ends in .html; the file is complete or absent."""
        checked_ending("path", path, [".html"])
        write_atomic(Path(path), self.page.encode())


@xarray.register_dataset_accessor("mehvar")  # type: ignore[no-untyped-call]
class Results:
    """Results of a run, or of the runs of a batch: plots, tables and pages.

    Parameters
    ----------
    dataset : xarray.Dataset
        Result of `mehvar.simulate`, `mehvar.batch` or `mehvar.open_result`.

    Raises
    ------
    InputError
        From any method, for any other dataset.
    """

    def __init__(self, dataset: xarray.Dataset) -> None:
        self._dataset = dataset

    def __repr__(self) -> str:
        about = self._dataset.attrs
        what = f"a batch of {self._dataset.sizes['run']} runs" if self._is_batch else "a run"
        methods = "plot scatter region convergence metrics again report" if self._is_batch else _OF_RUN
        return f"<mehvar: {what} of {about['model']} with {about['controller']}; methods: {methods.replace(' ', ', ')}>"

    def plot(self, *names: str, success: str | None = None) -> Figure:
        """Draw a run as `mehvar simulate --plot` does, or a batch as histograms of metrics or bands over time.

        Parameters
        ----------
        *names : str
            For a batch, metrics or stored series; default: all metrics.
        success : str, optional
            For a batch, the success condition as for `mehvar.batch`; default: the batch's own.

        Returns
        -------
        matplotlib.figure.Figure
            A figure of pyplot; a notebook shows it, and elsewhere `matplotlib.pyplot.show()`.

        Raises
        ------
        InputError
            If matplotlib is not installed, or for an unknown name.
        """
        from mehvar.pictures.spread import metrics_picture
        from mehvar.pictures.style import interactive_style
        from mehvar.reproduction.paper import result_picture

        with interactive_style():
            if self._is_batch:
                return metrics_picture(self._runs(success), names)
            if names or success is not None:
                raise InputError(
                    "a single run has no names and no success: leave both out. "
                    "To save the figure: plot().savefig('run.png')"
                )
            return result_picture(self._dataset, self._manifest)

    def scatter(self, x: str, y: str, success: str | None = None) -> Axes:
        """Draw one number of the runs of a batch against another, coloured by success.

        Parameters
        ----------
        x, y : str
            Metrics, drawn values, or expressions such as "final(roll)".
        success : str, optional
            As for `plot`.
        """
        from mehvar.pictures.spread import scatter_picture
        from mehvar.pictures.style import interactive_style

        with interactive_style():
            return scatter_picture(self._runs(success), x, y).axes[0]

    def region(self, x: str, y: str, success: str | None = None) -> Axes:
        """Draw the success rate of a batch in each cell of a plane, for example a region of attraction.

        Parameters
        ----------
        x, y : str
            As for `scatter`; drawn initial values, for a region of attraction.
        success : str, optional
            As for `plot`.
        """
        from mehvar.pictures.spread import region_picture
        from mehvar.pictures.style import interactive_style

        with interactive_style():
            return region_picture(self._runs(success), x, y).axes[0]

    def convergence(self, success: str | None = None) -> Axes:
        """Draw the share of successful runs over the number of runs, with its exact 95 % interval."""
        from mehvar.pictures.spread import convergence_picture
        from mehvar.pictures.style import interactive_style

        with interactive_style():
            return convergence_picture(self._runs(success)).axes[0]

    def metrics(self) -> pandas.DataFrame:
        """Return the metrics as a table with unit and meaning; for a batch, the statistics of `mehvar stats`.

        Mean and standard deviation are of the finite values, whose number is `count`; quantiles include infinite
        values.
        """
        import pandas

        if self._is_batch:
            from mehvar.report.batch import batch_metrics

            columns = ("count", "mean", "std", "min", "5%", "50%", "95%", "max")
            table = {
                row.name: (row.finite, row.mean, row.sd, row.smallest[1], *map(row.quantiles.get, (0.05, 0.5, 0.95)),
                           row.largest[1])
                for row in batch_metrics(self._runs(None))
            }  # fmt: skip
            return pandas.DataFrame.from_dict(table, orient="index", columns=columns, dtype=float)
        rows = metrics_of(self._manifest, self._dataset.attrs["controller"], list(map(str, self._dataset.data_vars)))
        values = metrics(self._dataset, self._manifest)
        return pandas.DataFrame(
            {
                "value": values,
                "unit": {name: rows[name].unit for name in values},
                "meaning": {name: rows[name].description for name in values},
            }
        )

    def again(
        self,
        run: int,
        controller: LawFunction | None = None,
        *,
        inputs: Mapping[str, Any] | xarray.Dataset | None = None,
        interpolation: Interpolation | None = None,
        model: Model | str | os.PathLike[str] | None = None,
    ) -> xarray.Dataset:
        """Repeat one run of a batch with all variables recorded, and check that it is bit-identical.

        Parameters
        ----------
        run : int
            Number of the run, counted from 0.
        controller : callable, optional
            The batch's Python law, with the recorded source. Default: the law with this source that ran a batch in
            this session, or the function of that name in the running program or notebook.
        inputs, interpolation : optional
            Inputs of a batch without a law, as for `mehvar.batch`.
        model : Model, str or path, optional
            The model. Default: the model of that name that is installed or in the current project, if its code
            matches the record.

        Returns
        -------
        xarray.Dataset
            As from `mehvar.simulate`.

        Raises
        ------
        InputError
            If this is a single run, the run does not exist or was impossible, or law or model differ from the record.
        MehvarError
            If the repeated run differs from the batch.

        Examples
        --------
        >>> import mehvar
        >>> runs = mehvar.batch("triangle", controller="path", n=20, vary={"rho": "uniform(0.2, 0.4)"})
        >>> bool(runs.mehvar.again(17)["theta"][-1] == runs["final"][17][3])
        True
        """
        from mehvar.runtime.batch.repeat import check_row, difference, plan_of, repeat_run
        from mehvar.runtime.batch.store.dataset import DatasetBatch
        from mehvar.runtime.run.results import to_dataset

        if not self._is_batch:
            raise bad_value("run", run, "left out: this result is a single run", "the call")
        if isinstance(run, bool) or not isinstance(run, Integral):
            raise bad_value("run", run, "the number of a run", "the call")
        batch = DatasetBatch(self._dataset)
        plan = plan_of(batch, model, controller=controller, inputs=inputs, interpolation=interpolation)
        check_row(plan, batch, run)
        repeated = repeat_run(plan, batch, run)
        if different := difference(repeated, plan, batch, run):
            raise MehvarError(f"run {run}: {different}")
        return to_dataset(repeated)

    def compare(self, other: xarray.Dataset) -> pandas.DataFrame:
        """Return the differences of another run from this one, one row per common variable.

        Parameters
        ----------
        other : xarray.Dataset
            A run with the same variables. Only samples that both runs have are compared, without interpolation.

        Returns
        -------
        pandas.DataFrame
            Columns `largest` (largest magnitude of the difference), `at` (its time, s), `rms` and `unit`.
        """
        import pandas

        if self._is_batch or not isinstance(other, xarray.Dataset) or "t" not in other.dims or "run" in other.dims:
            raise bad_value("other", type(other).__name__, "the dataset of a run, because this is a run")
        names = [str(name) for name, v in self._dataset.data_vars.items() if v.dims == ("t",) and name in other]
        here, there = _common_samples(self._dataset["t"].values, other["t"].values)
        if not names or not here.size:
            lacking = "samples at the same instants" if names else "variables of the same name"
            raise bad_value("other", f"a run without {lacking}", "a run with common ones")
        rows = {}
        for name in names:
            difference = np.abs(self._dataset[name].values[here] - other[name].values[there])
            largest = int(np.argmax(difference))
            rows[name] = {
                "largest": difference[largest],
                "at": self._dataset["t"].values[here[largest]],
                "rms": float(np.sqrt(np.mean(difference**2))),
                "unit": self._dataset[name].attrs.get("units", ""),
            }
        return pandas.DataFrame.from_dict(rows, orient="index")

    def report(self, path: str | os.PathLike[str], model: Model | str | os.PathLike[str] | None = None) -> Path:
        """Write a self-contained page about this run or batch, which any browser shows.

        Parameters
        ----------
        path : path
            The file, which ends in .html.
        model : Model, str or path, optional
            The model of a run, for its animation; default: the installed one.

        Returns
        -------
        Path
            The given path.

        Raises
        ------
        InputError
            If ending or model is wrong, or matplotlib is not installed.
        """
        from mehvar.report.page import write_page

        checked_ending("path", path, [".html"])
        return write_page(Path(path), self.page(model=model))

    def page(self, store: str = "", model: Model | str | os.PathLike[str] | None = None) -> Page:
        """Return the report as a page; `store` is the batch's folder, for the commands in it."""
        from mehvar.report.batch import batch_lead, batch_sections
        from mehvar.report.page import Page
        from mehvar.report.subjects import run_sections

        if self._is_batch:
            runs = self._runs(None)
            return Page(f"Batch: {self._title}", batch_sections(runs, store), batch_lead(runs))
        return Page(self._title, run_sections(self._dataset, self._manifest, model), self._dataset.attrs["title"])

    def animate(self, model: Model | str | os.PathLike[str] | None = None) -> Animation:
        """Return a 3-D animation of the run; a notebook shows it, and `save(path)` writes it.

        Parameters
        ----------
        model : Model, str or path, optional
            The model of the run, such as one from `mehvar.build`; default: the installed one.

        Raises
        ------
        InputError
            If this is a batch, the model is not the run's, or model and law have no animation.
        """
        from mehvar.report.page import Page, Section, page_text
        from mehvar.report.subjects import run_stage

        stage = None if self._is_batch else run_stage(self._dataset, self._manifest, model)
        if stage is None:
            about = self._dataset.attrs
            why = "this is a batch; animate a run" if self._is_batch else "its System declares no geometry (see Shape)"
            raise InputError(f"cannot animate {about['model']} with {about['controller']}: {why}")
        return Animation(page_text(Page(self._title, [Section("animation", "Animation", [stage])])))

    @property
    def _title(self) -> str:
        from mehvar.pictures.style import case_text

        about = self._dataset.attrs
        return f"{about['model']} under {about['controller']} (scenario {case_text(about)})"

    @property
    def _is_batch(self) -> bool:
        if "model" not in self._dataset.attrs:
            raise InputError("this dataset is not a result of mehvar: it has no attribute model")
        return "run" in self._dataset.dims

    @cached_property
    def _manifest(self) -> Manifest:
        about = self._dataset.attrs
        folder = known_models().get(about["model"], Path(about["model"]))
        return parse_manifest(about["manifest"], folder / FILE, any_age=True)

    def _runs(self, success: str | None) -> Runs:
        from mehvar.pictures.spread import Runs

        if not self._is_batch:
            raise unknown_name("dimension of this result", "run", map(str, self._dataset.dims))
        return Runs(self._dataset, success)


class Registration:
    """Entry of `xarray.chunkmanagers` by which `xarray.open_zarr` imports this module.

    `open_zarr` uses its own engine and loads no others, so that an engine entry would not suffice.
    """

    available = False


def _common_samples(one: NDArray[np.float64], other: NDArray[np.float64]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the indices of the instants that two increasing sequences share, up to rounding."""
    if not other.size:
        return (empty := np.zeros(0, dtype=np.intp)), empty
    right = np.searchsorted(other, one).clip(1, max(1, len(other) - 1)).clip(max=len(other) - 1)
    left = np.maximum(right - 1, 0)
    near = np.where(np.abs(other[left] - one) <= np.abs(other[right] - one), left, right)
    here = np.flatnonzero(np.isclose(other[near], one, rtol=1e-12, atol=1e-12))
    return here, near[here]
