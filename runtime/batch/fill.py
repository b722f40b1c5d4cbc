# SPDX-License-Identifier: Apache-2.0
"""Computation of a store's missing runs, block by block."""

from __future__ import annotations

import contextlib
import contextvars
import json
import os
import threading
import warnings
from collections.abc import Callable, Generator, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from queue import SimpleQueue
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mehvar.base.errors import InputError, MehvarError, bad_value, is_shortage

from ..arguments import check_arguments
from ..interrupts import KeptInterrupts, deferred
from ..model.catalogue import shipped_models
from ..model.model import Model, load
from ..model.parameters import advice
from ..run.options import Option
from ..run.problem import COMPLETE
from ..run.results import versions
from ..run.user.law import PythonLaw
from .blocks import IMPOSSIBLE, Blocks, BlockSource, Missing, Provenance, Values, check_names
from .evaluation.requirements import DECIDED, DecisionRule, checked_confidence, read_requirements
from .evaluation.statistics import Rule, StopRule, success_condition
from .numerics import other_numerics
from .plan import Campaign, Plan
from .store.attributes import IDENTITY
from .store.layout import STATUS, Layout
from .store.store import Store, create
from .store.store import resume as resume_store

if TYPE_CHECKING:
    from distributed import Client

BatchProgress = Callable[[int, int, int], None]
"""Function that receives the number of stored runs, of all runs, and of stored runs that ended early."""

_FEWEST, _MOST = 512, 65536  # runs per block
_SHORT, _SAMPLES = 4096, 2**20  # blocks of short runs have at least 4096 runs, but at most 2**20 samples
_BLOCKS = 256  # approximate number of blocks of a large batch
_BLOCK_BYTES = 2**26
REFUSALS = 3
"""Number of impossible runs per block with a stored reason, as many as the statistics show; others have only a
status.
"""

_MOST_THREADS = 1024
"""Largest number of threads, above the number of processors of any machine."""
_THREADS = Option("count", "Threads of this process", least=1, below=_MOST_THREADS + 1, name="threads")
_RUNS_PER_BLOCK = Option("count", "Runs per block", least=1, below=_MOST + 1, name="chunk")


class OutOfMemoryError(MehvarError, MemoryError):
    """Error for lack of memory for the next block; the store keeps finished blocks."""

    exit_status = 3
    resumable = True


class ImpossibleRunError(InputError):
    """Error for a run with invalid drawn values in a strict batch."""

    resumable = True


def run_batch(
    model: Model | str | os.PathLike[str],
    campaign: Campaign,
    out: str | os.PathLike[str] | None = None,
    *,
    resume: bool = False,
    success: str | None = None,
    until: str | None = None,
    require: Mapping[str, str] | None = None,
    confidence: float | None = None,
    strict: bool = False,
    threads: int | None = None,
    client: Client | None = None,
    chunk: int | None = None,
    report: BatchProgress | None = None,
    own: PythonLaw | None = None,
    origin: str = "the call",
) -> Store:
    """Run a campaign and store its runs.

    Parameters
    ----------
    model : Model, str or path
        A loaded model on the C backend, or what `load` takes.
    campaign : Campaign
        The runs.
    out : path, optional
        The store, a new folder; default: kept in memory.
    resume : bool
        Continue the store `out`, which may also be absent or complete; its damaged blocks are computed again.
    success : str, optional
        Condition that a successful run fulfils besides reaching its end; see `Condition`.
    until : str, optional
        Condition to stop, such as "ci(success) < 0.01", or "decided" to stop once each requirement is decided; see
        `StopRule` and `DecisionRule`.
    require : mapping of str to str, optional
        Requirements on the runs by name, which the store keeps; see `read_requirements`.
    confidence : float, optional
        Confidence of each requirement's bounds; default: 0.95.
    strict : bool
        Stop at the first run whose drawn values are not allowed, instead of marking it.
    threads : int, optional
        Threads of this process; default: one per available processor.
    client : distributed.Client, optional
        Workers that compute the blocks; default: this process.
    chunk : int, optional
        Runs per block; default: chosen from n and the stored data per run.
    report : callable, optional
        Called at the start and after each block.
    own : OwnLaw, optional
        A law written in Python instead of a law of the model; the campaign has its name.
    origin : str
        Origin of the arguments in error messages.

    Returns
    -------
    Store
        The complete store.

    Raises
    ------
    InputError
        For anything unknown, out of bounds or infeasible; for a store of another batch; with `strict`, for a run that
        is not allowed.
    StoreError
        If the store cannot be written. It keeps its blocks, and `resume` continues from there.
    OutOfMemoryError, ClusterError
        If memory does not suffice, or the scheduler is lost. The store keeps its blocks.
    """
    check_arguments("text", origin, success=success, until=until)
    check_arguments("path", origin, out=out)
    check_arguments("truth", origin, resume=resume, strict=strict)
    check_arguments("function", origin, report=report)
    chunk = _RUNS_PER_BLOCK.check(chunk, origin)
    used = used_threads(threads, origin)
    if client is not None and not hasattr(client, "submit"):
        raise bad_value("scheduler", client, "an address, or a distributed.Client", origin)
    if threads is not None and client is not None:
        raise bad_value("threads", threads, "left out with a scheduler: its workers have threads of their own", origin)
    if resume and out is None:
        raise bad_value("resume", resume, "left out unless out is a store", origin)
    loaded = model if isinstance(model, Model) else load(model, "c")
    if loaded.backend != "c":
        raise bad_value("backend", loaded.backend, "'c': batches need mehvar's C", origin)
    if own is not None and client is not None:
        raise bad_value("scheduler", client, "left out: a batch with a Python law runs in this process", origin)
    if own is not None and resume and not own.text:
        allowed = f"left out: the law in Python cannot be identified: {own.unidentified}"
        raise bad_value("resume", resume, allowed, origin)
    plan = Plan(loaded, campaign, origin, own)
    for text in advice(loaded.functions, plan.law, plan.nominal):
        warnings.warn(text, stacklevel=2)
    confidence = checked_confidence(confidence, origin)
    blocks = Blocks(plan, used)
    condition = success_condition(success)
    condition.check(blocks.scalars(), blocks.notes)
    requirements = read_requirements(require or {}, blocks.scalars(), blocks.notes, origin)
    design = "listed" if any(d.listed for d in plan.dispersions) else campaign.sampling
    rule: Rule | None = None
    if until is not None and until.strip() == DECIDED:
        rule = DecisionRule(requirements, confidence, design)
    elif until is not None:
        rule = StopRule(until, design, condition)
    kept_rules = {"success": success or "", "until": until or ""}
    if require:
        kept_rules["require"] = json.dumps({"requirements": dict(require), "confidence": confidence})
    if client is None:
        source = _local(blocks)
    else:
        from .workers import on_workers

        source = on_workers(client, plan, blocks.numerics)
    store = _opened(plan, blocks, out, resume, chunk, kept_rules)
    try:
        with store.writing(), KeptInterrupts() as kept:
            _Filling(store, plan, rule, strict, report, kept).run(source)
    except (MemoryError, RuntimeError) as error:
        if not is_shortage(error):
            raise
        allowed = f"free memory or use fewer threads than {blocks.threads}, then continue with --resume"
        what = f"not enough memory for a block of {store.chunk} runs ({' '.join(str(error).split()) or 'none is left'})"
        raise OutOfMemoryError(f"{what}: {allowed}") from error
    return store


def used_threads(threads: int | None, origin: str) -> int:
    """Return a checked number of threads; None means one per available processor."""
    return int(_THREADS.check(threads, origin) or available_processors())


def available_processors() -> int:
    """Return the number of processors available to this process."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _opened(
    plan: Plan,
    blocks: Blocks,
    out: str | os.PathLike[str] | None,
    resume: bool,
    chunk: int | None,
    rules: dict[str, str],
) -> Store:
    """Create the store, or open the one to continue."""
    path = None if out is None else Path(out)
    layout = _layout(plan, blocks, chunk, rules)
    if path is None or not resume or not path.exists():
        return create(path, layout)
    store = resume_store(path, layout, lambda attributes: _compare(str(path), attributes, layout.attributes))
    if chunk not in (None, store.chunk):
        raise bad_value("chunk", chunk, f"left out, or {store.chunk} as in {store.name}", plan.origin)
    return store


def _layout(plan: Plan, blocks: Blocks, chunk: int | None, rules: dict[str, str]) -> Layout:
    """Return the layout of a store: its arrays, what identifies its numbers, and what describes them."""
    variables = blocks.variables()
    check_names(variables)
    manifest, campaign = plan.model.manifest, plan.campaign
    bytes_per_run = sum(np.dtype(v.dtype).itemsize * max(v.size, 1) for v in variables)
    return Layout(
        n=campaign.n,
        chunk=chunk or _chunk(campaign.n, bytes_per_run, blocks.samples, bool(rules["until"])),
        variables=variables,
        coordinates=blocks.coordinates(),
        attributes={
            "title": f"{manifest.title}: {plan.law.title}",
            "model_source": _source(plan.model),
            **plan.facts(),
            "metrics": json.dumps([metric.name for metric in blocks.metrics]),
            "profile": plan.options.profile,
            "flags": blocks.provenance["flags"],
            "compiler": blocks.provenance["compiler"],
            "versions": json.dumps({**manifest.versions, **versions()}),
            "campaign": campaign.json_text(),
            **rules,
            "numerics": blocks.numerics,
            **({} if plan.own is None else {"law": plan.own.text}),
        },
    )


def _compare(store: str, there: Mapping[str, Any], here: Mapping[str, Any]) -> None:
    """Refuse to continue a store of another batch; the message names the difference."""
    for name in IDENTITY:
        stored, value = there.get(name, ""), here.get(name, "")
        if stored == value:
            continue
        if name == "numerics":
            differences = other_numerics(stored, value)
            raise InputError(
                f"{store} was made with other numerics: {differences}. "
                "Continue it on the machine that made it, or start another store"
            )
        if name == "law":
            stored, value = _other_lines(stored, value), _other_lines(value, stored)
        if name == "campaign":
            old, new = json.loads(stored), json.loads(value)
            # as texts: 0.0 is equal to -0.0, and runs with one of them may differ from those with the other
            name = next(name for name in {**old, **new} if repr(old.get(name)) != repr(new.get(name)))
            stored, value = old.get(name), new.get(name)
        raise InputError(
            f"{store} was made with {name} = {stored!r}, not {value!r}: use the original command, "
            "or choose another name for the store"
        )


def _other_lines(text: str, other: str) -> str:
    """Return the lines of a text that another one lacks."""
    return "\n".join(line for line in text.splitlines() if line not in other.splitlines())


def _chunk(n: int, bytes_per_run: int, samples: int, stops: bool) -> int:
    """Return the runs per block, a power of two, so that a large batch has some hundred blocks that fit into memory.

    Storing a block of any size takes tens of milliseconds. Short runs therefore get larger blocks, unless a stop rule
    is evaluated after each block.
    """
    fewest = _FEWEST if stops else max(_FEWEST, min(_SHORT, _SAMPLES // samples))
    runs = min(max(n // _BLOCKS, fewest), _MOST, max(1, _BLOCK_BYTES // bytes_per_run))
    return min(1 << (runs.bit_length() - 1), n)


def _source(model: Model) -> str:
    """Return the name or path that `load` needs for this model."""
    folder = model.manifest.folder
    return model.name if shipped_models().get(model.name) == folder else str(folder.absolute())


@dataclass
class _Filling:
    """Computation that fills a store until it is complete or the stop rule holds."""

    store: Store
    plan: Plan
    rule: Rule | None
    strict: bool
    report: BatchProgress | None
    kept: KeptInterrupts
    stored: int = 0
    failed: int = 0

    def run(self, source: BlockSource) -> None:
        """Count the intact stored blocks, then compute missing and damaged ones."""
        store = self.store
        verification = store.verify()
        for damage in verification.damaged:
            warnings.warn(f"{store.name}: {damage}; computed again", stacklevel=2)
        if any(self._is_enough(block, store.read(STATUS, [block])) for block in verification.whole):
            return
        self._tell_progress()
        missing = sorted(set(range(store.blocks())) - set(verification.whole))
        produced = source([(block, store.runs(block)) for block in missing])
        with contextlib.closing(produced):
            for block, values, provenance in produced:
                store.write(block, values, provenance=provenance, refusals=self._refusals(block, values[STATUS]))
                enough = self._is_enough(block, values[STATUS])
                self._tell_progress()
                self.kept.check()
                if enough:
                    return
        if not verification.complete:
            store.end(store.n)

    def _refusals(self, block: int, status: NDArray[Any]) -> dict[str, str]:
        """Return the reasons of a block's first impossible runs."""
        runs = self.store.runs(block).start + np.flatnonzero(status == IMPOSSIBLE)[:REFUSALS]
        return {str(run): self.plan.refusal(run) for run in runs.tolist()}

    def _is_enough(self, block: int, status: NDArray[Any]) -> bool:
        """Count a stored block; return True if the stop rule holds, and end the store there."""
        self.stored += len(status)
        self.failed += int(np.count_nonzero(~np.isin(status, COMPLETE)))
        impossible = np.flatnonzero(status == IMPOSSIBLE)
        if self.strict and impossible.size:
            refusal = self.plan.refusal(self.store.runs(block).start + int(impossible[0]))
            raise ImpossibleRunError(f"strict: {refusal}")
        if self.rule is None or not self.rule.holds_with(self.store, block):
            return False
        self.store.end(self.rule.runs)
        return True

    def _tell_progress(self) -> None:
        if self.report:
            self.report(self.stored, self.store.n, self.failed)


def _local(blocks: Blocks) -> BlockSource:
    """Return a source of blocks from this process; each is computed while the previous one is stored."""

    def produce(missing: Missing) -> Generator[tuple[int, Values, Provenance], None, None]:
        stop, done = threading.Event(), SimpleQueue[Future[Values | None]]()  # which a signal may interrupt
        context = contextvars.copy_context()  # a law in Python runs with the caller's precision of `decimal`
        with ThreadPoolExecutor(1) as pool:
            try:
                waiting: list[int] = []
                for block, runs in missing:
                    with deferred():
                        compute = pool.submit(context.run, blocks.compute, runs.start, len(runs), stop.is_set)
                        compute.add_done_callback(done.put)
                    waiting.append(block)
                    if len(waiting) > 1:
                        yield waiting.pop(0), _values(done.get()), blocks.provenance
                for block in waiting:
                    yield block, _values(done.get()), blocks.provenance
            finally:
                with deferred():
                    stop.set()

    return produce


def _values(future: Future[Values | None]) -> Values:
    values = future.result()
    if values is None:
        raise KeyboardInterrupt
    return values
