# SPDX-License-Identifier: Apache-2.0
"""Computation of blocks on the workers of a dask.distributed cluster.

A worker compiles the generated files for its processor and returns results to the process that owns the store. A
worker whose numerics differ from the owner's is refused.
"""

from __future__ import annotations

import asyncio
import itertools
import json
import threading
import warnings
from collections.abc import Callable, Generator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any, TypeVar

from mehvar.base import cache
from mehvar.base.errors import InputError, MehvarError
from mehvar.base.manifest import FILE

from ..compiling.compiler import require_compiler
from ..interrupts import deferred
from ..model.generated import generated_text
from ..model.model import load
from .blocks import Blocks, BlockSource, Missing, Provenance, Values
from .numerics import other_numerics
from .plan import Campaign, Plan

if TYPE_CHECKING:
    from distributed import Client

T = TypeVar("T")

_AHEAD = 2
"""Number of blocks in progress per thread of the cluster: one is computed, the next waits. With one, threads idle
during transfers; more than two delay an early end.
"""
_SILENCE = 5.0
"""Seconds without a block before a search for silent workers, which a second search confirms. Workers report every
second or two.
"""
_COMPILING = threading.Lock()
_READY: dict[str, Blocks] = {}


class ClusterError(MehvarError, RuntimeError):
    """Error if the scheduler or a block is lost; the store keeps its blocks."""

    exit_status = 1
    resumable = True


class WorkerError(InputError):
    """Error for an unusable worker; the store keeps its blocks."""

    resumable = True


@dataclass(frozen=True)
class Bundle:
    """Data for a worker: generated files by name, campaign and numerics in JSON."""

    files: Mapping[str, str]
    campaign: str
    numerics: str

    def key(self) -> str:
        """Return a hash of the contents."""
        return cache.key(self.campaign, self.numerics, *(text for item in sorted(self.files.items()) for text in item))

    def write(self, folder: Path) -> None:
        """Write the generated files."""
        for name, text in self.files.items():
            (folder / name).write_text(text, encoding="utf-8", newline="\n")


def connect(address: str, timeout: float = 10.0) -> Client:
    """Return a client of a running dask scheduler.

    Raises
    ------
    InputError
        If dask.distributed is missing, the address does not answer, or it needs certificates that are missing.
    """
    try:
        from distributed import Client
    except ModuleNotFoundError as error:
        raise InputError('a cluster needs dask.distributed: pip install "mehvar[cluster]"') from error
    if address.startswith("tls://"):
        _check_certificates(address)
    try:
        return Client(address, timeout=timeout, set_as_default=False)
    except (OSError, ValueError, TypeError, TimeoutError) as error:
        what = f"{type(error).__name__}: {error}".splitlines()[0]
        raise InputError(
            f"scheduler = {address!r}: must be the address of a running dask scheduler, as in tcp://host:8786 ({what})"
        ) from error


def _check_certificates(address: str) -> None:
    """Refuse a TLS address without certificates, because dask would retry until its timeout."""
    from distributed.security import Security

    allowed = "reached with certificates: set DASK_DISTRIBUTED__COMM__TLS__CA_FILE, ...CLIENT__CERT and ...CLIENT__KEY"
    try:
        context = Security().get_connection_args("client").get("ssl_context")
    except (OSError, ValueError) as error:  # a missing file, or no certificate
        raise InputError(f"scheduler = {address!r}: must be {allowed} ({error})") from error
    if context is None:
        raise InputError(f"scheduler = {address!r}: must be {allowed}")


def on_workers(client: Client, plan: Plan, numerics: str) -> BlockSource:
    """Return a source of blocks from a cluster's workers, in order of completion.

    Raises
    ------
    InputError
        If there is no worker, or one cannot compile.
    """
    bundle = _bundle(plan, numerics)
    _examine(client)

    def produce(missing: Missing) -> Generator[tuple[int, Values, Provenance], None, None]:
        shared = client.submit(_same, bundle, key=f"mehvar-bundle-{bundle.key()}")
        waiting = iter(missing)
        numbers: dict[Any, int] = {}
        done: SimpleQueue[Any] = SimpleQueue()
        watch = _Watch(client)

        def submit() -> None:
            for block, runs in itertools.islice(waiting, 1):
                with deferred():
                    future = client.submit(_compute, shared, runs.start, len(runs), pure=False, priority=-block)
                    numbers[future] = block
                    future.add_done_callback(done.put)

        threads = sum(client.nthreads().values())
        for _ in range(_AHEAD * max(threads, 1)):
            submit()
        try:
            while numbers:
                future = watch.wait(lambda timeout: done.get(timeout=timeout), Empty)
                yield numbers.pop(future), *_result(future, watch)
                submit()
        finally:
            with suppress(Exception):  # a lost scheduler cannot cancel anything
                client.cancel(list(numbers), force=True)

    def guarded(missing: Missing) -> Generator[tuple[int, Values, Provenance], None, None]:
        try:
            yield from produce(missing)
        except (MehvarError, GeneratorExit):
            raise
        except (Exception, asyncio.CancelledError) as error:  # many types of dask's own
            raise _lost(client, error) from error

    return guarded


def _bundle(plan: Plan, numerics: str) -> Bundle:
    manifest = plan.model.manifest
    names = [FILE, *sorted(path.name for path in manifest.folder.iterdir() if path.suffix in (".c", ".h"))]
    files = {name: generated_text(manifest, name) for name in names}
    return Bundle(files, plan.campaign.json_text(), numerics)


def _examine(client: Client) -> None:
    """Refuse a cluster with workers that cannot compile."""
    answers = client.run(_compiler, on_error="return")
    if not answers:
        raise InputError("the scheduler has no worker: start some with `dask worker ADDRESS`")
    for worker, answer in answers.items():
        if isinstance(answer, BaseException):
            raise InputError(f"the worker {worker} cannot be used: {answer}")


def _compiler() -> str:
    return require_compiler().version


def _same(bundle: Bundle) -> Bundle:
    return bundle


class _Watch:
    """Warning about silent workers during a wait for a block."""

    def __init__(self, client: Client) -> None:
        self._client = client
        self._silent: set[str] = set()

    def wait(self, get: Callable[[float], T], timeout_error: type[Exception]) -> T:
        """Return the result of `get`, called repeatedly with a timeout until it does not raise `timeout_error`."""
        seen: dict[str, float] = {}
        while True:
            try:
                return get(_SILENCE)
            except timeout_error:
                before, seen = seen, _last_seen(self._client)
                self._warn({worker for worker, at in seen.items() if before.get(worker) == at})

    def _warn(self, silent: set[str]) -> None:
        if new := sorted(silent - self._silent):
            warnings.warn(
                f"no block and no message for {_SILENCE:g} s from {', '.join(new)}: stop a worker that hangs; "
                "other workers then compute its blocks",
                stacklevel=2,
            )
        self._silent = silent


def _last_seen(client: Client) -> dict[str, float]:
    """Return the time of each worker's last report, by the scheduler's clock."""
    return {worker: about["last_seen"] for worker, about in client.scheduler_info()["workers"].items()}


def _result(future: Any, watch: _Watch) -> tuple[Values, Provenance]:
    error = future.exception()
    if error is not None:
        raise error
    result: tuple[Values, Provenance] = watch.wait(lambda timeout: future.result(timeout=timeout), TimeoutError)
    return result


def _lost(client: Client, error: BaseException) -> ClusterError:
    """Return mehvar's error for an error of dask."""
    if client.status != "running":
        return ClusterError(f"the scheduler {_address(client)} does not answer")
    return ClusterError(f"the cluster lost a block: {type(error).__name__}: {' '.join(str(error).split())}")


def _address(client: Client) -> str:
    return str(getattr(client.scheduler, "address", "")) or "of the cluster"


def _compute(bundle: Bundle, first: int, count: int) -> tuple[Values, Provenance]:
    """Compute a block on a worker with one thread, compiling only once."""
    from distributed import get_worker

    try:
        with _COMPILING:
            blocks = _blocks(bundle.key(), bundle)
        values = blocks.compute(first, count)
    except InputError as error:
        raise WorkerError(f"the worker {get_worker().address} cannot be used: {error}") from error
    if values is None:
        raise RuntimeError("a block failed on every worker that tried it")
    return values, blocks.provenance


def _blocks(key: str, bundle: Bundle) -> Blocks:
    if key not in _READY:
        folder = cache.entry("models", key, bundle.write)
        blocks = Blocks(Plan(load(folder, "c"), Campaign(**json.loads(bundle.campaign))), threads=1)
        if differences := other_numerics(bundle.numerics, blocks.numerics):
            raise InputError(f"its numerics differ: {differences}")
        _READY[key] = blocks
    return _READY[key]
