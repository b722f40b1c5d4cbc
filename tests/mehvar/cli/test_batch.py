# SPDX-License-Identifier: Apache-2.0
"""`mehvar batch`, `mehvar stats` and `mehvar simulate --from` as a user meets them."""

from __future__ import annotations

import importlib.util
import json
import math
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray

import mehvar
from mehvar.__main__ import main
from mehvar.campaign import read_campaign
from mehvar.runtime.batch.store.store import open_store
from mehvar.runtime.units import read_value
from tests import commands
from tests.runtime.batch.forgery import contents

BATCH = ("batch", "triangle", "--controller", "path", "--seed", "3", "--t-end", "0.5")
VARY = ("--vary", "l1_0=normal(0.2, 0.01)", "--vary", "theta=uniform(0.8, 1.2)")
KILL_TEST = Path(__file__).parents[3] / "benchmarks" / "batch" / "kill_test.py"


def run(*arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run([*commands.mehvar(), *arguments], capture_output=True, text=True, cwd=cwd, timeout=120)


def refused(*arguments: str, cwd: Path) -> str:
    done = run(*arguments, cwd=cwd)
    assert done.returncode == 2, done.stdout + done.stderr
    assert "Traceback" not in done.stderr
    return done.stderr


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a finished batch."""
    place = tmp_path_factory.mktemp("batch")
    done = run(*BATCH, "-n", "40", *VARY, "--vary", "R=uniform(0.6, 0.72)", "--save", "every=0.1", "--out", "runs.zarr",
               "--success", "final(rho) < 0.25", cwd=place)  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert done.stderr == "", "quiet when not a terminal"
    (place / "printed.txt").write_text(done.stdout)
    return place


def test_statistics_stand_at_the_end_and_come_again(folder: Path) -> None:
    printed = (folder / "printed.txt").read_text()
    again = run("stats", "runs.zarr", cwd=folder)
    assert again.returncode == 0
    assert again.stdout in printed
    with xarray.open_zarr(folder / "runs.zarr") as plain:
        impossible = int((plain.status == 5).sum())
        good = int(((plain.status == 0) & (plain.final.sel(state="rho") < 0.25)).sum())
        worst = int(np.nanargmax(plain.travel.values))
        assert 0 < impossible < 40
    assert f"done {40 - impossible}  impossible {impossible}" in again.stdout
    assert f"success (final(rho) < 0.25): {good} of 40" in again.stdout
    _, extremes = again.stdout.split("extreme runs\n")
    assert next(line.split()[-1] for line in extremes.splitlines() if line.startswith("travel")) == str(worst)
    assert "R = 0.7" in again.stdout
    assert "must be in (0, 0.707106781187)" in again.stdout


def test_another_condition_and_a_picture(folder: Path) -> None:
    drawn = ("--plot", "bands.png", "--of", "theta", "--of", "travel")
    done = run("stats", "runs.zarr", "--success", "max_rho < 1", *drawn, cwd=folder)
    assert "success (max_rho < 1): " in done.stdout
    assert (folder / "bands.png").read_bytes().startswith(b"\x89PNG")
    assert "unknown series or metric" in refused("stats", "runs.zarr", "--plot", "x.png", "--of", "thta", cwd=folder)


def test_a_run_comes_again_bit_for_bit_with_full_logging(folder: Path) -> None:
    with xarray.open_zarr(folder / "runs.zarr") as plain:
        possible = int(np.flatnonzero(plain.status.values == 0)[3])
        impossible = int(np.flatnonzero(plain.status.values == 5)[0])
        final = plain.final[possible].values
    done = run("simulate", "--from", "runs.zarr", "--run", str(possible), "--out", "run.nc", cwd=folder)
    assert done.returncode == 0, done.stderr
    assert "the same as in the store, bit for bit" in done.stdout
    repeated = mehvar.open_result(folder / "run.nc")
    assert repeated.sizes["t"] == 51
    assert [float(repeated[name][-1]) for name in ("rho", "phi", "mu", "theta")] == final.tolist()
    message = refused("simulate", "--from", "runs.zarr", "--run", str(impossible), cwd=folder)
    assert f"(from run {impossible}): must be in" in message
    assert "run = 40: must be a whole number from 0 to 39" in refused(
        "simulate", "--from", "runs.zarr", "--run", "40", cwd=folder
    )
    assert "--from STORE needs --run ID" in refused("simulate", "--from", "runs.zarr", cwd=folder)
    assert "--from STORE needs --run ID" in refused("simulate", "triangle", "--run", "3", cwd=folder)


def test_file_command_line_and_python_give_the_same_bytes(tmp_path: Path) -> None:
    text = """
        model = "triangle"
        controller = "path"
        n = 12
        seed = 3
        t_end = 0.5
        sampling = "latin"
        out = "file.zarr"
        save = { every = 0.1 }
        [set]
        disturbance = 0.001
        [vary]
        l1_0 = "normal(0.2, 0.01)"
        theta = "uniform(0.8, 1.2)"
    """
    (tmp_path / "campaign.toml").write_text(text, encoding="utf-8-sig", newline="\r\n")
    done = run("batch", "campaign.toml", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    arguments = ("-n", "12", "--sampling", "latin", "--save", "every=0.1", "--set", "disturbance=0.001")
    done = run(*BATCH, *VARY, *arguments, "--out", "line.zarr", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    ds = mehvar.batch(
        "triangle",
        controller="path",
        n=12,
        seed=3,
        sampling="latin",
        save=0.1,
        t_end=0.5,
        disturbance=0.001,
        vary={"theta": "uniform(0.8, 1.2)", "l1_0": "normal(0.2, 0.01)"},
        out=tmp_path / "python.zarr",
    )
    assert dict(ds.sizes) == {"run": 12, "state": 4, "variable": 18, "t": 6}
    again = mehvar.batch(tmp_path / "campaign.toml", out=tmp_path / "again.zarr")
    assert again.l1_0.identical(ds.l1_0)
    wanted = contents(tmp_path / "file.zarr")
    for name in ("line.zarr", "python.zarr", "again.zarr"):
        assert contents(tmp_path / name) == wanted, name


@pytest.mark.soak
def test_units_of_line_and_file_give_the_bytes_of_the_numbers(tmp_path: Path) -> None:
    (tmp_path / "campaign.toml").write_text(
        "model = 'triangle'\ncontroller = 'path'\nn = 3\nseed = 3\nt_end = 0.5\nout = 'file.zarr'\n"
        "set = { disturbance = '3 rad/min' }\n"
        "vary = { theta = 'uniform(45deg, 90deg)', l1_0 = 'normal(20 cm, 10 mm)' }\n",
        encoding="utf-8",
    )
    units = (
        "--vary",
        "theta=uniform(45deg, 90deg)",
        "--vary",
        "l1_0=normal(20cm, 10mm)",
        "--set",
        "disturbance=3rad/min",
    )
    low, high, mean, sd = (
        read_value(*pair) for pair in (("45deg", "rad"), ("90deg", "rad"), ("20cm", "m"), ("10mm", "m"))
    )
    assert (low, high, mean, sd) == pytest.approx((math.pi / 4, math.pi / 2, 0.2, 0.01), rel=1e-15)
    rate = read_value("3rad/min", "rad/s")
    numbers = (f"theta=uniform({low}, {high})", f"l1_0=normal({mean}, {sd})", f"disturbance={rate}")
    plain = tuple(zip(("--vary", "--vary", "--set"), numbers, strict=True))
    for words in (
        ("batch", "campaign.toml"),
        (*BATCH, "-n", "3", *units, "--out", "units.zarr"),
        (*BATCH, "-n", "3", *(word for pair in plain for word in pair), "--out", "numbers.zarr"),
    ):
        done = run(*words, cwd=tmp_path)
        assert done.returncode == 0, done.stderr
    wanted = contents(tmp_path / "numbers.zarr")
    assert contents(tmp_path / "units.zarr") == wanted
    assert contents(tmp_path / "file.zarr") == wanted


def test_units_in_python_and_in_times_of_a_file_are_those_of_the_command_line(tmp_path: Path) -> None:
    degrees, radians = (
        mehvar.batch("triangle", "path", n=3, t_end=0.1, vary={"theta": text})
        for text in ("uniform(45deg, 60 deg)", "uniform(0.7853981633974483, 1.0471975511965976)")
    )
    assert degrees["final"].equals(radians["final"])
    file = tmp_path / "campaign.toml"
    file.write_text("model = 'triangle'\ncontroller = 'path'\nn = 2\nt_end = '100ms'\nsave = { every = '50 ms' }\n")
    assert mehvar.batch(file)["t"].values.tolist() == [0.0, 0.05, 0.1]
    with pytest.raises(mehvar.InputError, match=r"theta = '1 m'.*in rad"):
        mehvar.batch("triangle", "path", n=3, vary={"theta": "uniform(1 m, 2 m)"})


def test_a_batch_in_memory() -> None:
    ds = mehvar.batch("triangle", "path", n=5, vary={"theta": "normal(1, 0.1)"}, t_end=0.1)
    assert dict(ds.sizes) == {"run": 5, "state": 4, "variable": 18}
    assert ds.initial_theta.attrs["units"] == "rad"
    assert next(iter(ds.data_vars)) == "initial_theta"
    with pytest.raises(mehvar.InputError, match="a batch needs n, the number of runs, and a controller"):
        mehvar.batch("triangle")


@pytest.mark.parametrize(
    ("toml", "message"),
    [
        ("n = 0", r"n = 0 \(from .*campaign.toml\): must be a whole number >= 1"),
        ("n = 5\nnn = 3", r"campaign.toml: nn is not known \(did you mean 'n'\?\)"),
        ("n = 5\nsampling = 'halton'", "campaign.toml: sampling = 'halton': must be random, latin"),
        ("n = 5\nsave = { evry = 1 }", "campaign.toml: save.e"),
        ("n = 5\n[vary]\nR = 3", "campaign.toml: vary.R = 3"),
        ("n = = 5", "campaign.toml is not TOML"),
        ("", "campaign.toml: n is missing"),
        ("n = 5\n[set]\nseed = 4", "seed = 4.*given with --seed"),
    ],
)
def test_a_campaign_file_with_a_mistake_is_refused(tmp_path: Path, toml: str, message: str) -> None:
    (tmp_path / "campaign.toml").write_text(f"model = 'triangle'\ncontroller = 'path'\n{toml}\n")
    with pytest.raises(mehvar.InputError, match=message):
        mehvar.batch(tmp_path / "campaign.toml")


ONE = (*BATCH[:4], "--t-end", "0.5", "-n", "1", "--out", "new.zarr")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((*BATCH, "-n", "0", "--out", "new.zarr"), "n = 0 (from -n): must be a whole number >= 1"),
        (BATCH[:-2], "a batch needs -n N"),
        (("batch", "triangle", "-n", "1"), "a run of triangle needs a law: --controller sliding or path"),
        ((*BATCH, "-n", "1"), "a batch needs a store: --out STORE.zarr"),
        ((*ONE, "--vary", "R"), "--vary = 'R': must be NAME=DIST(...)"),
        ((*ONE, "--vary", " =normal(0, 1)"), "--vary = ' =normal(0, 1)': must be NAME=DIST(...)"),
        ((*ONE, "--vary", "R=normal(0.9, 0.01)"), "must be in (0, 0.707106781187)"),
        ((*ONE, "--vary", "R=nrmal(1, 2)"), "unknown distribution 'nrmal' of R"),
        ((*ONE, "--vary", "R=choice(1)", "--vary", "R=choice(2)"), "--vary R is given twice"),
        ((*ONE, "--save", "often"), "save = 'often' (from --save): must be a number"),
        ((*ONE, "--seed", "3"), "seed = 3 (from the command line): must be left out unless values are drawn"),
        ((*ONE, "--sampling", "latin"), "sampling = 'latin' (from the command line): must be left out"),
        ((*ONE, "--save", "every=1"), "save = 1.0 (from the command line): must be a multiple of the sampling step"),
        ((*ONE, "--threads", "0"), "threads = 0 (from the command line): must be a whole number >= 1"),
        ((*ONE, "--threads", "1", "--set", "step=0.1"), "step = 0.1 (from the command line): must be left out"),
        ((*ONE, "--until", "soon"), "until = 'soon'"),
        ((*ONE, "--success", "max_rho"), "success = 'max_rho': must be a condition"),
        ((*ONE, "--success", "max_roh < 1"), "did you mean max_rho"),
        ((*ONE, "--sampling", "grid"), "sampling = 'grid'"),
        ((*ONE, "--set", "backend=python"), "backend = 'python'"),
        ((*ONE, "--scheduler", "tls://127.0.0.1:9"), "must be reached with certificates"),
        ((*ONE[:-1], "/no/such/new.zarr"), "the folder /no/such does not exist"),
        ((*ONE[:-1], "/sys/new.zarr"), "cannot write /sys/new.zarr: "),
        (("stats", "none.zarr"), "no batch store none.zarr"),
        (("verify", "none.zarr"), "no batch store none.zarr"),
        (("simulate", "--trust-model"), "--from STORE needs --run ID"),
    ],
)
def test_mistakes_are_named_and_leave_nothing_behind(
    tmp_path: Path,
    arguments: tuple[str, ...],
    message: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["mehvar", *arguments])
    with pytest.raises(SystemExit) as ended:
        main()
    said = capsys.readouterr().err
    assert ended.value.code == 2
    assert message in " ".join(said.split())
    assert not list(tmp_path.iterdir())


def test_a_store_that_cannot_be_written_stops_with_the_way_to_go_on(folder: Path, tmp_path: Path) -> None:
    """Files have a limit of 8 KiB: what a full disk comes to."""
    arguments = (*BATCH, *VARY, "-n", "5000", "--out", str(tmp_path / "runs.zarr"))
    assert run(*arguments, cwd=tmp_path).returncode == 0
    whole = contents(tmp_path / "runs.zarr")
    (tmp_path / "runs.zarr" / "records" / "1.json").unlink()
    (tmp_path / "runs.zarr" / "records" / "end.json").unlink()
    limited = ["bash", "-c", 'ulimit -f 8; exec "$@"', "-", sys.executable, "-m", "mehvar", *arguments, "--resume"]
    done = subprocess.run(limited, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 3, done.stderr
    assert "runs.zarr: File too large" in done.stderr
    assert "4096 of 5000 runs are stored; go on with: mehvar batch" in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert "--resume" in done.stderr
    assert run(*arguments, "--resume", cwd=tmp_path).returncode == 0
    assert contents(tmp_path / "runs.zarr") == whole


def test_verify_says_whole_or_what_is_not(folder: Path, tmp_path: Path) -> None:
    done = run("verify", "runs.zarr", cwd=folder)
    assert (done.returncode, done.stdout) == (0, "runs.zarr: 40 runs; 1 of 1 blocks are whole\n")
    shutil.copytree(folder / "runs.zarr", tmp_path / "runs.zarr")
    (tmp_path / "runs.zarr" / "final" / "c" / "0" / "0").unlink()
    done = run("verify", "runs.zarr", cwd=tmp_path)
    assert done.returncode == 1
    assert "damaged: block 0 (runs 0 to 39): final/c/0/0 is missing" in done.stdout
    facts = json.loads(run("verify", "runs.zarr", "--json", cwd=tmp_path).stdout)
    assert facts["damaged"][0]["files"] == {"final/c/0/0": "missing"}
    assert "final/c/0/0 is missing" in refused("stats", "runs.zarr", cwd=tmp_path)


def test_two_first_starts_lose_nothing(folder: Path, tmp_path: Path) -> None:
    """One has the name, the other is told; `benchmarks/batch/store.py starts` does it fifty times."""
    line = [sys.executable, "-P", "-m", "mehvar", *BATCH, *VARY, "-n", "600", "--out", "runs.zarr"]
    pair = [subprocess.Popen(line, cwd=tmp_path, stderr=subprocess.PIPE, text=True) for _ in range(2)]
    said = {process.communicate(timeout=120)[1]: process.returncode for process in pair}
    assert sorted(said.values()) == [0, 2], said
    message = next(text for text, status in said.items() if status)
    assert "another process is writing runs.zarr: process" in message or "exists already" in message
    assert [path.name for path in tmp_path.iterdir()] == ["runs.zarr"]
    assert mehvar.verify(tmp_path / "runs.zarr").complete


def test_an_interrupt_stops_cleanly_and_says_how_to_go_on(tmp_path: Path) -> None:
    """Between two blocks and in the middle of one."""
    arguments = ["batch", "triangle", "--controller", "path", "-n", "100000", "--out", "runs.zarr", "--threads", "1"]
    process = subprocess.Popen(
        [sys.executable, "-m", "mehvar", *arguments],
        cwd=tmp_path,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # ignored where the tests are a background job
    )
    wait_until(lambda: (tmp_path / "runs.zarr" / "records" / "0.json").exists())
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "Traceback" not in said
    stored = sum(map(len, map(open_store(tmp_path / "runs.zarr").runs, open_store(tmp_path / "runs.zarr").stored())))
    assert f"interrupted; {stored} of 100000 runs are stored; go on with:" in " ".join(said.split())
    assert f"mehvar {' '.join(arguments)} --resume" in " ".join(said.split())


def wait_until(condition: Any) -> None:
    end = time.monotonic() + 60
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.02)


def test_progress_is_shown_on_a_terminal(tmp_path: Path) -> None:
    import pty

    master, slave = pty.openpty()
    command = [sys.executable, "-P", "-m", "mehvar", *BATCH, *VARY, "-n", "1200", "--out", "runs.zarr"]
    process = subprocess.Popen(command, cwd=tmp_path, stderr=slave, stdout=subprocess.DEVNULL,
                               env={**os.environ, "TERM": "xterm", "COLUMNS": "150"})  # fmt: skip
    os.close(slave)
    shown = b""
    try:
        while piece := os.read(master, 4096):
            shown += piece
    except OSError:
        pass
    assert process.wait(60) == 0
    text = shown.decode()
    assert "1200/1200 runs" in text
    assert "0 not done" in text
    assert "left" in text


@pytest.mark.soak
def test_a_killed_batch_goes_on_with_the_same_bytes(tmp_path: Path) -> None:
    """The benchmark `kill_test.py`, made small."""
    spec = importlib.util.spec_from_file_location("kill_test", KILL_TEST)
    assert spec is not None
    assert spec.loader is not None
    kill_test = importlib.util.module_from_spec(spec)
    sys.modules["kill_test"] = kill_test
    spec.loader.exec_module(kill_test)
    tally = kill_test.torment(tmp_path, 3, 1_000, random.Random(1))
    assert sum(tally.kills.values()) == 3


def test_the_manifest_of_a_store_says_how_it_came_about(folder: Path) -> None:
    said = open_store(folder / "runs.zarr").attributes
    assert said["model_hash"] == mehvar.load("triangle").manifest.hash
    campaign = json.loads(said["campaign"])
    assert campaign["seed"] == 3
    assert campaign["vary"]["l1_0"] == "normal(0.2, 0.01)"
    assert {"mehvar", "numpy", "zarr"} <= json.loads(said["versions"]).keys()
    assert "-ffp-contract=off" in said["flags"]


@pytest.mark.parametrize("stand", [".", "sub", "../elsewhere"])
@pytest.mark.parametrize("absolute", [False, True])
@pytest.mark.parametrize(
    ("model", "meant"),
    [
        ("triangle", "mehvar's model of this name"),
        ("./triangle", "triangle"),
        ("other", "other"),
        ("sub/../other", "other"),
        ("own", "generated/own"),
    ],
)
def test_a_campaign_file_means_one_model_wherever_one_stands(
    model: str, meant: str, absolute: bool, stand: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A name comes first, as on the command line; a folder counts from the file, whose project has the names."""
    project, elsewhere = tmp_path / "project", tmp_path / "elsewhere"
    pendulum = Path(__file__).parents[2] / "runtime" / "pendulum"
    for place in ("triangle", "other", "generated/own"):
        shutil.copytree(pendulum, project / place)
        shutil.copytree(pendulum, elsewhere / place)
    for folder in (project, elsewhere):
        (folder / "models" / "own").mkdir(parents=True)
        (folder / "models" / "own" / "system.py").touch()
    (project / "sub").mkdir()
    (project / "a.toml").write_text(f'model = "{model}"\ncontroller = "pd"\nn = 1\n')
    monkeypatch.chdir(project / stand)
    path = project / "a.toml" if absolute else Path(os.path.relpath(project / "a.toml"))
    file = read_campaign(path)
    wanted = mehvar.load("triangle").manifest.folder if "mehvar" in meant else project / meant
    assert Path(file.model).is_absolute()
    assert Path(file.model).samefile(wanted)


def test_deep_toml_is_refused_in_a_line(tmp_path: Path) -> None:
    (tmp_path / "deep.toml").write_text(f"model = {'[' * 3000}")
    assert "deep.toml is not TOML: it is nested too deeply" in refused("batch", "deep.toml", cwd=tmp_path)
