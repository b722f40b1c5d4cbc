# SPDX-License-Identifier: Apache-2.0
"""A model goes from process to process: pickled, spawned and forked, with the same bits as here."""

from __future__ import annotations

import multiprocessing
import pickle
import warnings
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import pytest

from mehvar import runtime
from mehvar.runtime import InputError, Model


def final(job: tuple[Model, float]) -> list[float]:
    """Run in another process; return where the run ended."""
    model, rate = job
    run = runtime.simulate(model, "pd", t_end=0.3, initial={"rate": rate})
    return [*map(float, run.x[-1]), float(run.u[-1, 0])]


@pytest.mark.parametrize("method", ["spawn", "fork"])
def test_a_pool_computes_what_this_process_does(pendulum: Model, method: str) -> None:
    jobs = [(pendulum, 0.1 * k) for k in range(8)]
    expected = [final(job) for job in jobs]  # the model is in use here: compiled code is loaded, threads have run
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # Python 3.12 warns of forks beside threads
        with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context(method)) as pool:
            assert list(pool.map(final, jobs)) == expected


@pytest.mark.parametrize("backend", ["c", "python"])
def test_a_model_in_use_pickles(folder: Path, backend: str) -> None:
    model = runtime.load(folder, backend)
    before = runtime.simulate(model, "pd", t_end=0.1).x
    again = pickle.loads(pickle.dumps(model))
    assert (again.name, again.backend) == (model.name, backend)
    assert (runtime.simulate(again, "pd", t_end=0.1).x == before).all()


def test_another_model_in_its_place_is_refused(edited: Callable[[str, str, str], Path]) -> None:
    edited("pendulum.h", 'HASH "', 'HASH "a')
    text = pickle.dumps(runtime.load(edited("manifest.json", '"hash": "', '"hash": "a')))
    edited("pendulum.h", 'HASH "a', 'HASH "b')
    edited("manifest.json", '"hash": "a', '"hash": "b')
    with pytest.raises(InputError, match="has changed since the model was pickled"):
        pickle.loads(text)
