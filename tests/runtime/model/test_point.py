# SPDX-License-Identifier: Apache-2.0
"""A call at one point: the numbers of the loop over many, and nothing shared between calls."""

from __future__ import annotations

import shutil
import threading

import numpy as np
import pytest

import mehvar
from mehvar.base.errors import InputError
from mehvar.base.manifest import with_digest
from mehvar.runtime.model.catalogue import known_models
from mehvar.runtime.model.model import shared_model


@pytest.mark.parametrize("name", sorted(known_models()))
@pytest.mark.share(3)
def test_a_point_is_an_element_of_an_array(name):
    """Every function of every model, bit for bit, and of the same type."""
    model = mehvar.load(name)
    generator = np.random.default_rng(0)
    for function in model.functions.values():
        arguments = [generator.uniform(0.1, 1.0, spec.shape) for spec in function.function.arguments]
        at_point = function(*arguments)
        looped = function(*[np.stack([argument] * 2) for argument in arguments])
        several = len(function.function.results) > 1
        for point, pair in zip(at_point if several else [at_point], looped if several else [looped], strict=True):
            assert np.array_equal(point, pair[1], equal_nan=True), function
            assert type(point) is type(pair[1])


def test_a_result_is_the_callers_own_and_arguments_stay():
    model = mehvar.load("triangle")
    x, u, p = model.state(rho=0.3, mu=0.2), np.array([0.1, 0.2, 0.3]), model.parameters()
    copies = x.copy(), u.copy(), p.copy()
    first = model.rhs(x, u, p)
    kept = first.copy()
    model.rhs(2 * x, u, p)
    first[:] += 0.0
    assert np.array_equal(first, kept)
    assert all(np.array_equal(*pair) for pair in zip((x, u, p), copies, strict=True))


def test_wrong_arguments_are_refused_as_ever():
    model = mehvar.load("triangle")
    x, u, p = model.state(rho=0.3, mu=0.2), np.zeros(3), model.parameters()
    for arguments in ((x, u), (x, u[:2], p), (x[:, None], u, p), (x.astype(complex), u, p)):
        with pytest.raises(InputError):
            model.functions["rhs"](*arguments)


def test_threads_do_not_share_buffers():
    model = mehvar.load("slosh")
    u, p = np.zeros(5), model.parameters()
    states = [model.state(vx=float(k), phi1=0.1 * k) for k in range(4)]
    expected = [model.rhs(x, u, p) for x in states]
    wrong: list[int] = []

    def repeat(k: int) -> None:
        wrong.extend(k for _ in range(2000) if not np.array_equal(model.rhs(states[k], u, p), expected[k]))

    threads = [threading.Thread(target=repeat, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not wrong


def test_a_shared_model_is_loaded_again_when_its_folder_changes(tmp_path):
    folder = tmp_path / "triangle"
    shutil.copytree(known_models()["triangle"], folder)
    first = shared_model(folder)
    assert shared_model(str(folder)) is first
    manifest = folder / "manifest.json"
    manifest.write_text(
        with_digest(manifest.read_text().replace('"title": "triangle', '"title": "another triangle', 1))
    )
    assert shared_model(folder) is not first
    (folder / "triangle.c").unlink()
    with pytest.raises(InputError):
        mehvar.simulate(folder, "path", t_end=0.1)
