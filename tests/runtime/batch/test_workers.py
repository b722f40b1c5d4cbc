# SPDX-License-Identifier: Apache-2.0
"""Batches on a real dask scheduler with real worker processes."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import dask.config as dask_config
import numpy as np
import pytest
from distributed import Client

from mehvar.base.errors import InputError
from mehvar.runtime.batch import workers
from mehvar.runtime.batch.fill import run_batch
from mehvar.runtime.batch.plan import Campaign
from mehvar.runtime.batch.store.store import Store, open_store
from mehvar.runtime.batch.store.verification import verify
from mehvar.runtime.batch.workers import WorkerError, connect

ROOT = Path(__file__).parents[3]
CAMPAIGN = Campaign(
    "path", n=96, seed=5, vary={"l1_0": "normal(0.2, 0.01)", "R": "uniform(0.6, 0.72)"}, options={"t_end": 0.5}
)
PATIENCE = "2s"  # until a killed process counts as lost


def dask(*arguments: str, cwd: Path | None = None, **environment: str) -> subprocess.Popen[bytes]:
    path = os.pathsep.join(filter(None, [str(ROOT), os.environ.get("PYTHONPATH")]))
    return subprocess.Popen(
        [sys.executable, "-m", "dask", *arguments],
        cwd=cwd,
        env={**os.environ, "PYTHONPATH": path, "DASK_DISTRIBUTED__COMM__TIMEOUTS__CONNECT": PATIENCE, **environment},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )


def worker(address: str, name: str, **environment: str) -> subprocess.Popen[bytes]:
    options = ("--nthreads", "1", "--no-nanny", "--no-dashboard", "--name", name, "--local-directory")
    return dask("worker", address, *options, environment.pop("FOLDER", "/tmp"), **environment)


@pytest.fixture(scope="module")
def scheduler(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    file = tmp_path_factory.mktemp("dask") / "scheduler.json"
    process = dask("scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file", str(file))
    try:
        dask_config.set({"distributed.comm.timeouts.connect": PATIENCE})
        with Client(scheduler_file=str(file), timeout=60, set_as_default=False) as client:
            address = str(client.scheduler.address)  # type: ignore[union-attr]
        yield address
    finally:
        process.terminate()
        process.wait()


@pytest.fixture
def client(scheduler: str) -> Iterator[Client]:
    with connect(scheduler) as result:
        yield result


@pytest.fixture(scope="module")
def here() -> Store:
    return run_batch("triangle", CAMPAIGN)


def same(one: Store, other: Store) -> bool:
    return all(np.array_equal(one.read(name), other.read(name), equal_nan=name != "status") for name in one.variables())


def stop(*processes: subprocess.Popen[bytes]) -> None:
    for process in processes:
        process.terminate()
    for process in processes:
        process.wait()


def test_workers_give_the_bits_of_this_process(scheduler: str, client: Client, here: Store, tmp_path: Path) -> None:
    """One of two workers has a cache of its own and compiles for itself; alone at first, or the other may do it all."""
    processes = [worker(scheduler, "own", FOLDER=str(tmp_path), MEHVAR_CACHE=str(tmp_path / "cache"))]
    try:
        client.wait_for_workers(1, timeout=60)
        run_batch("triangle", replace(CAMPAIGN, n=8), tmp_path / "few.zarr", client=client)
        assert list((tmp_path / "cache").rglob("*.so"))
        processes.append(worker(scheduler, "shared", FOLDER=str(tmp_path)))
        client.wait_for_workers(2, timeout=60)
        store = run_batch("triangle", CAMPAIGN, tmp_path / "runs.zarr", client=client, chunk=8)
        assert same(store, here)
    finally:
        stop(*processes)


@pytest.mark.soak
def test_a_worker_gets_the_jacobians_of_an_implicit_method(scheduler: str, client: Client, tmp_path: Path) -> None:
    campaign = replace(CAMPAIGN, n=8, options={"t_end": 0.5, "method": "rodas5p"})
    process = worker(scheduler, "implicit", FOLDER=str(tmp_path), MEHVAR_CACHE=str(tmp_path / "cache"))
    try:
        client.wait_for_workers(1, timeout=60)
        assert same(
            run_batch("triangle", campaign, tmp_path / "runs.zarr", client=client), run_batch("triangle", campaign)
        )
    finally:
        stop(process)


@pytest.mark.soak
def test_a_killed_worker_costs_time_only(scheduler: str, client: Client, here: Store, tmp_path: Path) -> None:
    first = worker(scheduler, "doomed", FOLDER=str(tmp_path))
    later: list[subprocess.Popen[bytes]] = []
    try:
        client.wait_for_workers(1, timeout=60)

        def report(runs: int, *_: int) -> None:
            if runs >= 16 and not later:
                first.send_signal(signal.SIGKILL)
                later.append(worker(scheduler, "spare", FOLDER=str(tmp_path)))

        store = run_batch("triangle", CAMPAIGN, tmp_path / "runs.zarr", client=client, chunk=8, report=report)
        assert later
        assert same(store, here)
    finally:
        stop(first, *later)


def test_a_worker_without_a_compiler_is_named(scheduler: str, client: Client, tmp_path: Path) -> None:
    process = worker(scheduler, "bare", FOLDER=str(tmp_path), CC="/no/such/cc")
    try:
        client.wait_for_workers(1, timeout=60)
        with pytest.raises(InputError, match=r"the worker tcp://.* cannot be used: .*/no/such/cc"):
            run_batch("triangle", CAMPAIGN, tmp_path / "runs.zarr", client=client)
    finally:
        stop(process)


@pytest.mark.soak
def test_a_worker_with_other_sources_is_refused_and_adds_no_block(
    scheduler: str, client: Client, tmp_path: Path
) -> None:
    """A comment in mehvar's C is another text: whether it changes a bit is not for a worker to say."""
    for room in ("mehvar", "runtime", "generated"):
        skip = shutil.ignore_patterns("__pycache__")
        shutil.copytree(ROOT / room, tmp_path / "other" / room, ignore=skip, symlinks=True)
    header = tmp_path / "other" / "runtime" / "native" / "batch" / "metrics.h"
    header.write_text(header.read_text() + "/* other */\n")
    process = worker(scheduler, "other", FOLDER=str(tmp_path), PYTHONPATH=str(tmp_path / "other"), PYTHONSAFEPATH="1")
    out = tmp_path / "runs.zarr"
    try:
        client.wait_for_workers(1, timeout=60)
        message = r"the worker tcp://.* cannot be used: its numerics differ.*mehvar's own C \("
        with pytest.raises(WorkerError, match=message):
            run_batch("triangle", CAMPAIGN, out, client=client, chunk=8)
        assert open_store(out).stored() == []
    finally:
        stop(process)
    run_batch("triangle", CAMPAIGN, out, resume=True)
    assert verify(out).complete


@pytest.mark.soak
def test_a_worker_that_hangs_is_named(
    scheduler: str, client: Client, here: Store, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And the batch goes on when it does, with the same bits."""
    monkeypatch.setattr(workers, "_SILENCE", 2.0)
    process = worker(scheduler, "hanging", FOLDER=str(tmp_path))
    try:
        address = ""
        while not address:  # those of other tests may not be gone yet
            names = {about["name"]: address for address, about in client.scheduler_info()["workers"].items()}
            address = names.get("hanging", "")

        def report(runs: int, *_: int) -> None:
            if runs == 16:
                process.send_signal(signal.SIGSTOP)
                threading.Timer(12.0, process.send_signal, [signal.SIGCONT]).start()

        with pytest.warns(
            UserWarning, match=rf"no block and no message for 2 s from {address}: stop a worker that hangs"
        ):
            store = run_batch("triangle", CAMPAIGN, tmp_path / "runs.zarr", client=client, chunk=8, report=report)
        assert same(store, here)
        assert verify(tmp_path / "runs.zarr").complete
    finally:
        process.send_signal(signal.SIGCONT)
        stop(process)


@pytest.mark.soak
def test_a_scheduler_that_is_lost_ends_the_command_in_one_line(tmp_path: Path) -> None:
    file, out = tmp_path / "scheduler.json", tmp_path / "runs.zarr"
    options = ("--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file", str(file))
    processes = [dask("scheduler", *options)]
    try:
        with Client(scheduler_file=str(file), timeout=60, set_as_default=False) as client:
            address = str(client.scheduler.address)  # type: ignore[union-attr]
            processes.append(worker(address, "lonely", FOLDER=str(tmp_path)))
            client.wait_for_workers(1, timeout=60)
        line = ["batch", "triangle", "--controller", "path", "-n", "400000", "--scheduler", address, "--out", str(out)]
        batch = subprocess.Popen(
            [sys.executable, "-m", "mehvar", *line],
            env={**os.environ, "PYTHONPATH": str(ROOT), "DASK_DISTRIBUTED__COMM__TIMEOUTS__CONNECT": PATIENCE},
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )
        while not (out / "records" / "0.json").exists() and batch.poll() is None:
            time.sleep(0.1)
        processes[0].kill()
        said = batch.communicate(timeout=120)[1]
    finally:
        for process in reversed(processes):
            process.kill()
            process.wait()
    assert batch.returncode == 1, said
    assert said.count("\n") == 1, said
    assert said.startswith(f"mehvar: the scheduler {address} does not answer; ")
    assert said.endswith(f"go on with: mehvar {' '.join(line)} --resume\n")
    assert verify(out).sound
    assert open_store(out).stored()


@pytest.mark.soak
def test_the_page_on_tls_is_right(tmp_path: Path) -> None:
    """Its commands, on this machine: with the certificates a batch runs, without them it is refused."""
    page = (ROOT / "docs" / "how-to" / "batch-on-a-cluster.md").read_text(encoding="utf-8")
    keys, servers = re.findall(r"```bash\n(.*?)```", page.partition("## With TLS")[2], flags=re.DOTALL)[:2]
    subprocess.run(["bash", "-ec", keys], cwd=tmp_path, check=True, capture_output=True)
    lines = {line.split()[1]: line for line in servers.splitlines() if line.startswith("dask")}
    settings = dict(line.removeprefix("export ").split("=", 1) for line in servers.splitlines() if "export" in line)
    assert set(lines) == {"scheduler", "worker"}
    assert len(settings) == 4
    out, file = tmp_path / "runs.zarr", tmp_path / "scheduler.json"
    here = f"--host 127.0.0.1 --port 0 --no-dashboard --scheduler-file {file}"
    server = dask(*lines["scheduler"].replace("--port 8786", here).split()[1:], cwd=tmp_path)
    processes = [server]
    try:
        while not file.exists() and server.poll() is None:
            time.sleep(0.1)
        address = json.loads(file.read_text())["address"]
        assert address.startswith("tls://")
        line = lines["worker"].replace("tls://head:8786", address).replace("$(nproc)", "1 --no-nanny --no-dashboard")
        processes.append(dask(*line.split()[1:], cwd=tmp_path))
        batch = [
            sys.executable,
            "-m",
            "mehvar",
            "batch",
            "triangle",
            "--controller",
            "path",
            "-n",
            "8",
            "--t-end",
            "0.1",
        ]
        batch += ["--t-end", "0.1", "--out", str(out), "--scheduler", address]
        bare = {**os.environ, "PYTHONPATH": str(ROOT), "DASK_DISTRIBUTED__COMM__TIMEOUTS__CONNECT": PATIENCE}
        refused = subprocess.run(batch, cwd=tmp_path, env=bare, capture_output=True, text=True, check=False)
        assert refused.returncode == 2
        assert "must be reached with certificates: set DASK_DISTRIBUTED__COMM__TLS__CA_FILE" in refused.stderr
        assert "Traceback" not in refused.stderr
        assert not out.exists()
        for _ in range(60):  # until the worker is there
            done = subprocess.run(
                batch, cwd=tmp_path, env={**bare, **settings}, capture_output=True, text=True, check=False
            )
            if "has no worker" not in done.stderr:
                break
        assert done.returncode == 0, done.stderr
    finally:
        for process in reversed(processes):
            process.kill()  # over TLS a worker whose scheduler ends at the same time does not
            process.wait()
    assert verify(out).complete


def test_a_cluster_without_workers_is_refused_and_the_store_can_go_on(client: Client, tmp_path: Path) -> None:
    out = tmp_path / "runs.zarr"
    with pytest.raises(InputError, match="no worker: start some with `dask worker"):
        run_batch("triangle", replace(CAMPAIGN, n=8), out, client=client)
    run_batch("triangle", replace(CAMPAIGN, n=8), out, resume=True)
    assert open_store(out).stored() == [0]


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:9", "nonsense", "tcp://no.such.host.invalid:8786"])
def test_a_scheduler_that_is_not_there_is_named(address: str) -> None:
    with pytest.raises(InputError, match=rf"scheduler = '{address}': must be the address of a running dask scheduler"):
        connect(address, timeout=0.1)


@pytest.mark.soak
def test_tls_without_certificates_is_refused_at_once(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="must be reached with certificates: set DASK_"):
        connect("tls://127.0.0.1:9")
    names = ("ca-file", "client.cert", "client.key")
    missing = {f"distributed.comm.tls.{name}": str(tmp_path / "none.pem") for name in names}
    with dask_config.set(missing), pytest.raises(InputError, match="No such file"):
        connect("tls://127.0.0.1:9")
