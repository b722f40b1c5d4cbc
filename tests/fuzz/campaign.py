# SPDX-License-Identifier: Apache-2.0
"""Fuzz campaigns: numbers of accepted and refused inputs, and other outcomes."""

from __future__ import annotations

import contextlib
import io
import os
import signal
import subprocess
import sys
import tempfile
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from stat import S_ISDIR
from typing import NoReturn

import numpy as np

import mehvar
from mehvar.__main__ import _run, main
from mehvar.base.errors import InputError
from mehvar.campaign import read_campaign
from mehvar.runtime.batch.dispersions import read_dispersions
from mehvar.runtime.batch.evaluation.conditions import Criterion
from mehvar.runtime.batch.evaluation.statistics import StopRule

from . import inputs

ROOT = Path(mehvar.__file__).parents[1]
Run = Callable[..., tuple[int, str]]
"""Function from the arguments of a command to its exit status and messages."""
STATUSES = {0, 1, 2, 3}
_LONGEST = 4000
"""Largest length of a message: lists of known names are shorter, unshortened values longer."""
_SECONDS = 60
"""Limit on a command: a hundred times the slowest on an idle machine."""


@dataclass
class Outcome:
    """Outcome of a campaign's inputs; `findings` must stay empty."""

    counts: Counter[str] = field(default_factory=Counter)
    findings: list[str] = field(default_factory=list)


def expressions(seed: int, count: int) -> Outcome:
    """Read conditions, distributions and stop rules; evaluate accepted ones."""
    random, outcome = Random(seed), Outcome()
    values = np.array([0.0, 1.0, -1.0, np.nan, np.inf, 1e308])
    for _ in range(count):
        kind = random.choices((_condition, _distribution, _stop_rule), (8, 4, 1))[0]
        text = inputs.distribution(random) if kind is _distribution else inputs.expression(random)
        text = inputs.damaged(random, text) if random.random() < 0.2 else text
        _try(outcome, repr(text)[:300], lambda kind=kind, text=text: kind(text, values))
    return outcome


def campaign_files(seed: int, count: int, folder: Path) -> Outcome:
    """Read campaign files and prepare their batches."""
    random, outcome = Random(seed), Outcome()
    path = folder / "fuzz.toml"
    for _ in range(count):
        text = inputs.campaign(random)
        path.write_text(text, encoding="utf-8", errors="replace")
        _try(outcome, text, lambda: read_campaign(path).campaign("the file"))
    return outcome


def commands(seed: int | str, count: int, folder: Path, run: Run) -> Outcome:
    """Run commands in a folder with a campaign `c.toml` and a store `s.zarr`, by one of the three functions below."""
    random, outcome = Random(seed), Outcome()
    for _ in range(count):
        arguments = inputs.command(random)
        before = snapshot(folder)
        with contextlib.chdir(folder):
            status, text = run(*arguments)
        after = snapshot(folder)
        outcome.counts[f"{arguments[0] if arguments else ''} {status}"] += 1
        if wrong := _wrong(status, text, before == after):
            outcome.findings.append(f"{wrong}: {arguments!r}\n{text[-1500:]}")
        for path in sorted(after.keys() - before.keys(), reverse=True):  # what is in a folder, then the folder
            (folder / path).rmdir() if (folder / path).is_dir() else (folder / path).unlink()
    return outcome


def furnish(folder: Path, run: Run) -> None:
    """Put a campaign file `c.toml`, inputs over time `in.csv` and a store `s.zarr` into a folder."""
    batch = ("batch", str(inputs.PENDULUM), "--controller", "pd", "-n", "4", "--t-end", "0.05")
    text = f"model = '{inputs.PENDULUM}'\ncontroller = 'pd'\nn = 2\nt_end = 0.05\nout = 'new.zarr'\n"
    (folder / "c.toml").write_text(text)
    (folder / "in.csv").write_text("t [s],torque [N m]\n0,0\n0.1,1\n")
    with contextlib.chdir(folder):
        status, text = run(*batch, "--vary", "k_p=normal(16, 0.1)", "--save", "every=0.01", "--out", "s.zarr")
    assert status == 0, text


def damaged_stores(seed: int, count: int, store: Path, probe: Callable[[], tuple[int, str]]) -> Outcome:
    """Flip a bit or cut the end of a file of a store, check the store, and repair it."""
    random, outcome = Random(seed), Outcome()
    files = sorted(path for path in store.rglob("*") if path.is_file())
    for _ in range(count):
        path = random.choice(files)
        whole = path.read_bytes()
        place = random.randrange(max(1, len(whole)))
        flipped = bytes([whole[place] ^ 1 << random.randrange(8)]) if whole else b"x"
        path.write_bytes(whole[:place] + flipped + whole[place + 1 :] if random.random() < 0.7 else whole[:place])
        status, text = probe()
        outcome.counts[str(status)] += 1
        if wrong := _wrong(status, text, True):
            outcome.findings.append(f"{wrong}: {path.relative_to(store)} at {place}\n{text[-1500:]}")
        path.write_bytes(whole)
    return outcome


def snapshot(folder: Path) -> dict[str, tuple[int, int]]:
    """Return size and time of every file in a folder, and the names of its folders."""
    parts = {str(path.relative_to(folder)): path.stat() for path in sorted(folder.rglob("*"))}
    return {name: (0, 0) if S_ISDIR(s.st_mode) else (s.st_size, s.st_mtime_ns) for name, s in parts.items()}


def _condition(text: str, values: np.ndarray) -> None:
    criterion = Criterion(text)
    result = criterion(dict.fromkeys(criterion.names, values))
    assert result.shape == values.shape
    assert result.dtype == np.bool_


def _distribution(text: str, _: np.ndarray) -> None:
    for names in ("a", "a, b"):
        with contextlib.suppress(InputError):
            (dispersion,) = read_dispersions({names: text})
            dispersion.centre()
    read_dispersions({"a": text})


def _stop_rule(text: str, _: np.ndarray) -> None:
    StopRule(f"ci(success) < {text}", "random").holds([3], 10)


def _try(outcome: Outcome, what: str, call: Callable[[], object]) -> None:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            call()
        outcome.counts["taken"] += 1
    except InputError as error:
        outcome.counts["refused"] += 1
        if len(str(error)) > _LONGEST or not str(error).strip():
            outcome.findings.append(f"{what}: a message of {len(str(error))} characters")
    except BaseException as error:
        outcome.findings.append(f"{what}: {type(error).__name__}: {error}")


def _wrong(status: int, text: str, untouched: bool) -> str:
    """Return the fault of a command's end; empty without a fault."""
    if status not in STATUSES:
        return f"status {status}"
    if "Traceback" in text or "Exception ignored" in text:
        return "a traceback"
    if "Path(" in text:
        return "a path as Python spells it"
    if status == 2 and not untouched:
        return "refused, and yet something was written"
    if status == 2 and ("rror" not in text and "mehvar: " not in text):
        return "refused without a word"
    lines = [line for line in text.splitlines() if line.startswith("mehvar: ")]
    return "a message that is too long" if any(len(line) > _LONGEST for line in lines) else ""


def in_process(*arguments: str) -> tuple[int, str]:
    """Run a command in this process; return its exit status and messages."""
    output = io.TextIOWrapper(io.BytesIO(), encoding="utf-8", errors="backslashreplace")
    argv = sys.argv
    try:
        sys.argv = ["mehvar", *arguments]
        with contextlib.redirect_stdout(output), contextlib.redirect_stderr(output), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            status = _status(_run)
    finally:
        sys.argv = argv
    output.seek(0)
    return status, output.read()


def forked(*arguments: str) -> tuple[int, str]:
    """Run a command in a fork of this process; a signal gives a negative status."""
    with tempfile.TemporaryFile() as output:
        child = os.fork()
        if not child:
            _be_a_command(arguments, output.fileno())
        status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        output.seek(0)
        return status, output.read().decode(errors="replace")


def as_process(*arguments: str) -> tuple[int, str]:
    """Run a command as a shell does."""
    raw = [os.fsencode(argument) for argument in arguments]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])}
    done = subprocess.run(
        [sys.executable, "-m", "mehvar", *raw], capture_output=True, env=environment, timeout=120, check=False
    )
    return done.returncode, (done.stdout + done.stderr).decode(errors="replace")


def _be_a_command(arguments: Sequence[str], output: int) -> NoReturn:
    """End this process like `mehvar`; an alarm ends it by a signal after too long a time."""
    signal.alarm(_SECONDS)
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    os.dup2(output, 1)
    os.dup2(output, 2)
    sys.stdout = sys.__stdout__ = io.TextIOWrapper(io.FileIO(1, "w"), encoding="utf-8")
    sys.stderr = sys.__stderr__ = io.TextIOWrapper(io.FileIO(2, "w"), encoding="utf-8", errors="backslashreplace")
    sys.argv = ["mehvar", *arguments]
    status = _status(main)
    status = _status(sys.stdout.flush) or status
    sys.stderr.flush()
    os._exit(status & 0xFF)


def _status(call: Callable[[], object]) -> int:
    """Return the exit status of an interpreter after a call."""
    try:
        call()
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else int(bool(end.code))
    except BaseException:
        traceback.print_exc()
        return 1
    return 0
