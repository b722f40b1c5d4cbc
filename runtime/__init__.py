# SPDX-License-Identifier: Apache-2.0
"""Compilation and simulation of generated models; needs NumPy and a C compiler.

One run, `run.simulate.simulate`:

1. `model.model.load`. In: a folder generated/MODEL. Out: a `Model`; its functions are compiled C or the Python module.
2. `model.parameters.resolve` and `run.options`. In: arguments, scenario, manifest. Out: vectors p, s, c with the origin
   of each value, and options.
3. `run.problem.problem_of`. In: all of it. Out: a `Problem`: initial state, instants, method, addresses of functions.
4. `run.loop.run`. In: the problem. Out: a `Trajectory`, from the closed loop of native/step with a method of
   native/methods; functions in Python are called back.
5. `run.results.to_dataset` and `run.metrics`. In: the `Run`. Out: an xarray.Dataset with units, origins and metrics.

A batch, `batch.fill.run_batch`:

1. `batch.plan.Plan`. In: model and campaign. Out: resolved values of each run, drawn by `batch.sampling`; a run depends
   on its number only.
2. `batch.source` and `batch.kernel`. In: generated C and the same native/step. Out: a library for which a double is a
   register of 2, 4 or 8 runs.
3. `batch.blocks.Blocks`. In: numbers of runs. Out: their values, in threads of this process or by `batch.workers`.
4. `batch.store`. In: blocks. Out: a Zarr store, a record after each chunk, so that a killed batch can be resumed.
5. `batch.evaluation`. In: the store. Out: statistics, sensitivities, requirements.

On a board, `board.run.run_on_board` runs the law in `board.firmware`, from the same generated C, and the plant here.
"""

from mehvar.base.errors import BuildError, InputError
from mehvar.base.manifest import Manifest, read_manifest

from .model.catalogue import find_model, known_models, list_models
from .model.model import Model, load
from .run.formats import open_result, save
from .run.metrics import metrics
from .run.problem import Status
from .run.results import to_dataset
from .run.simulate import Run, simulate

__all__ = [
    "BuildError",
    "InputError",
    "Manifest",
    "Model",
    "Run",
    "Status",
    "find_model",
    "known_models",
    "list_models",
    "load",
    "metrics",
    "open_result",
    "read_manifest",
    "save",
    "simulate",
    "to_dataset",
]
