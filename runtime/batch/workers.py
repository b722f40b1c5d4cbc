# SPDX-License-Identifier: Apache-2.0
"""Blocks computed by the workers of a dask.distributed cluster.

A worker gets the generated files themselves and compiles them for its own processor; results go back to the process
that owns the store.
"""

from __future__ import annotations

import json
import threading
from collections.abc import Generator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mehvar import cache
from mehvar.errors import InputError
from mehvar.manifest import FILE

from ..compiling.compiler import require_compiler
from ..model.model import load
from .blocks import Blocks, BlockSource, Missing, Values
from .plan import Campaign, Plan

if TYPE_CHECKING:
    from distributed import Client

_AHEAD = 2
"""Blocks per thread of the cluster that are under way: one is computed while the next waits beside it. With one a
thread is idle while its result travels; more only means more to cancel when a batch ends early."""
_COMPILING = threading.Lock()
_READY: dict[str, Blocks] = {}


@dataclass(frozen=True)
class Bundle:
    """All that a worker needs: generated files by name, and the campaign as JSON."""

    files: Mapping[str, str]
    campaign: str

    def key(self) -> str:
        """Return a hash of the contents."""
        return cache.key(self.campaign, *(text for item in sorted(self.files.items()) for text in item))

    def write(self, folder: Path) -> None:
        """Write the generated files."""
        for name, text in self.files.items():
            (folder / name).write_text(text, encoding="utf-8", newline="\n")


def connect(address: str, timeout: float = 10.0) -> Client:
    """Return a client of a running scheduler.

    Raises
    ------
    InputError
        If dask.distributed is missing or nobody answers at the address.
    """
    try:
        from distributed import Client
    except ModuleNotFoundError as error:
        raise InputError('a cluster needs dask.distributed: pip install "mehvar[cluster]"') from error
    try:
        return Client(address, timeout=timeout, set_as_default=False)
    except (OSError, ValueError, TypeError, TimeoutError) as error:
        what = f"{type(error).__name__}: {error}".splitlines()[0]
        raise InputError(
            f"scheduler = {address!r}: must be the address of a running dask scheduler, as in tcp://host:8786 ({what})"
        ) from error


def on_workers(client: Client, plan: Plan) -> BlockSource:
    """Return what computes blocks on the workers of a cluster, in the order in which they are ready.

    Raises
    ------
    InputError
        If there is no worker, or one that cannot compile.
    """
    bundle = _bundle(plan)
    _examine(client)

    def produce(missing: Missing) -> Generator[tuple[int, Values], None, None]:
        from distributed import as_completed

        shared = client.submit(_same, bundle, key=f"mehvar-bundle-{bundle.key()}")
        waiting = iter(missing)
        numbers: dict[Any, int] = {}

        def submit() -> Any:
            following = next(waiting, None)
            if following is None:
                return None
            block, runs = following
            future = client.submit(_compute, shared, runs.start, len(runs), pure=False, priority=-block)
            numbers[future] = block
            return future

        threads = sum(client.nthreads().values())
        started = [future for _ in range(_AHEAD * max(threads, 1)) if (future := submit()) is not None]
        under_way = as_completed(started, loop=client.loop)
        try:
            for future in under_way:
                block = numbers.pop(future)
                yield block, _result(future)
                if (following := submit()) is not None:
                    under_way.add(following)
        finally:
            client.cancel(list(numbers), force=True)

    return produce


def _bundle(plan: Plan) -> Bundle:
    manifest = plan.model.manifest
    sources = (path for path in manifest.folder.iterdir() if path.suffix in (".c", ".h"))
    names = [FILE, *sorted(path.name for path in sources if not path.stem.endswith("_jac"))]
    files = {name: (manifest.folder / name).read_text(encoding="utf-8") for name in names}
    return Bundle(files, plan.campaign.json_text())


def _examine(client: Client) -> None:
    """Refuse a cluster whose workers cannot compile, before any work is sent."""
    answers = client.run(_compiler, on_error="return")
    if not answers:
        raise InputError("the scheduler has no worker: start some with `dask worker ADDRESS`")
    for worker, answer in answers.items():
        if isinstance(answer, BaseException):
            raise InputError(f"the worker {worker} cannot take part: {answer}")


def _compiler() -> str:
    return require_compiler().version


def _same(bundle: Bundle) -> Bundle:
    return bundle


def _result(future: Any) -> Values:
    error = future.exception()
    if error is None:
        values: Values = future.result()
        return values
    if isinstance(error, InputError):
        raise error
    raise RuntimeError(f"the cluster lost a block: {type(error).__name__}: {error}") from error


def _compute(bundle: Bundle, first: int, count: int) -> Values:
    """Run on a worker: compile once, then compute; one thread, since the worker runs one block per thread."""
    from distributed import get_worker

    try:
        with _COMPILING:
            blocks = _blocks(bundle.key(), bundle)
        values = blocks.compute(first, count)
    except InputError as error:
        raise InputError(f"the worker {get_worker().address} cannot take part: {error}") from error
    if values is None:
        raise RuntimeError("a block was given up")
    return values


def _blocks(key: str, bundle: Bundle) -> Blocks:
    if key not in _READY:
        folder = cache.entry("models", key, bundle.write)
        plan = Plan(load(folder, "c"), Campaign(**json.loads(bundle.campaign)))
        _READY[key] = Blocks(plan, threads=1)
    return _READY[key]
