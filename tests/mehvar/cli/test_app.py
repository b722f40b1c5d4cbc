# SPDX-License-Identifier: Apache-2.0
"""The command line as a user meets it: exit status, one clear message, no traceback, files whole."""

import os
import re
import shutil
import subprocess
import sys
import threading
from pathlib import Path

import pytest

import mehvar
from tests import commands
from tests.fuzz.campaign import in_process

TIGHT = ("--set", "R=0.3", "--set", "l1_f=0.45", "--set", "l2_f=0.45")
SIMULATE = ("simulate", "triangle", "--controller", "path", "--t-end", "1")


def run(*arguments: str, cwd: Path | None = None, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [*commands.mehvar(), *arguments],
        capture_output=True,
        text=True,
        cwd=cwd,
        env={**os.environ, **environment},
        timeout=120,
    )


def refused(*arguments: str, cwd: Path | None = None) -> str:
    done = run(*arguments, cwd=cwd)
    assert done.returncode == 2, done.stdout + done.stderr
    assert "Traceback" not in done.stderr
    return done.stderr


@pytest.mark.parametrize(
    ("arguments", "needs"),
    [
        (("export", "fmu", "triangle"), "export fmu needs --out FILE.fmu"),
        (("convert", "run.nc"), "convert needs --out FILE"),
        (("require",), "require needs STORE|CAMPAIGN.toml"),
    ],
)
def test_what_a_command_lacks_is_named(arguments: tuple[str, ...], needs: str) -> None:
    said = refused(*arguments)
    assert said.startswith(f"mehvar: {needs}")
    assert "Usage" not in said


def test_list_and_show_name_everything():
    assert "triangle" in run("list").stdout
    shown = run("show", "triangle").stdout
    for word in (
        "rho",
        "w3",
        "u_l1",
        "k_phi",
        "eta_rho",
        "k_phi*R/m",
        "paper-b",
        "printed",
        "sliding",
        "m^2/s",
        "length_rates",
    ):
        assert word in shown


def test_simulate_prints_saves_and_draws(tmp_path):
    done = run(*SIMULATE, "--out", "run.nc", "--plot", "run.png", "--set", "disturbance=0.001", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "T_theta" in done.stdout
    assert (tmp_path / "run.png").read_bytes().startswith(b"\x89PNG")
    saved = mehvar.open_result(tmp_path / "run.nc")
    assert saved["l1"].attrs["units"] == "m"
    assert '"disturbance": 0.001' in saved.attrs["parameters"]
    assert sorted(p.name for p in tmp_path.iterdir()) == ["run.nc", "run.png"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("show", "triangel"), "unknown model .*'triangel'.*did you mean triangle"),
        (("simulate", "triangle", "--controller", "slide"), "unknown controller 'slide' of triangle"),
        ((*SIMULATE, "--scenario", "papre"), "unknown scenario 'papre' of triangle.*did you mean paper"),
        ((*SIMULATE, "--set", "no_such=1"), "unknown parameter or option 'no_such'.*--set"),
        ((*SIMULATE, "--set", "R=0.71"), r"R = 0.71 \(from --set\): must be in \(0, 0.707"),
        ((*SIMULATE, "--set", "R=nan"), "R = nan"),
        ((*SIMULATE, "--set", "R=big"), "R = 'big'.*must be a number"),
        ((*SIMULATE, "--set", "R"), "--set = 'R'.*NAME=VALUE"),
        ((*SIMULATE, "--set", "R=0.6", "--set", "R=0.61"), "--set R is given twice"),
        ((*SIMULATE, "--set", "R=0.4"), "R = 0.4 must be larger than rho_f"),
        (
            (*SIMULATE, "--set", "R=0.3", "--set", "l1_f=0.45", "--set", "l2_f=0.45"),
            "R = 0.3 must be larger than rho of the initial",
        ),
        ((*SIMULATE, "--set", "l1_0=0.1", "--set", "l2_0=0.1"), "initial rods .* do not form a triangle"),
        ((*SIMULATE, "--set", "l3_0=0.4"), "do not form a triangle"),
        ((*SIMULATE, "--set", "l1_f=0"), r"l1_f = 0.0 \(from --set\): must be in \(0, inf\) m"),
        ((*SIMULATE, "--set", "l1_f=-0.3"), "l1_f = -0.3"),
        ((*SIMULATE, "--set", "delay=1"), "delay = 1.*left out unless the law is sampled"),
        ((*SIMULATE, "--set", "hold=0.003"), "one must be an integer multiple of the other"),
        (("simulate", "triangle", "--controller", "path", "--t-end", "-1"), "t_end = -1 "),
        ((*SIMULATE, "--out", "/no/such/folder/run.nc"), "output file = '/no/such/folder/run.nc'.*folder that exists"),
        ((*SIMULATE, "--plot", "run.xyz"), "run.xyz"),
        (("generate", "triangel"), "unknown model 'triangel'"),
        (("generate", "triangle", "--structure", "masses=general"), "--structure .* --out DIR"),
        (("generate", "triangle", "--structure", "masses", "--out", "x"), "--structure = 'masses'.*NAME=VALUE"),
        (
            ("generate", "triangle", "--structure", "masses=odd", "--out", "x"),
            "masses = 'odd' is not one of equal, general",
        ),
        (("generate", "triangle", "--emit", "fortran"), "--emit = 'fortran'.*must be casadi"),
    ],
)
def test_a_mistake_gets_one_clear_message(arguments, message, tmp_path, monkeypatch):
    folder = tmp_path if arguments[0] == "simulate" else Path(mehvar.__file__).parents[1]
    monkeypatch.chdir(folder)
    status, text = in_process(*arguments)
    assert status == 2, text
    assert re.search(message, text.replace("\n", " ")), text
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("verb", [("diff", "triangle"), ("verify",), ("show",), ("stats",)])
def test_a_name_without_end_does_not_fill_the_terminal(verb):
    assert len(refused(*verb, "9" * 4000)) < 1500


def test_unknown_commands_and_options_are_usage_errors():
    assert run("simulat").returncode == 2
    assert run("simulate", "triangle").returncode == 2


def test_a_folder_that_cannot_be_written_is_refused_before_the_run(tmp_path):
    (tmp_path / "file").write_text("")
    assert "output file" in refused(*SIMULATE, "--out", str(tmp_path / "file" / "run.nc"))


@pytest.mark.parametrize("text", ["{", '{"schema": 99}', "[]"])
def test_a_damaged_model_folder_is_refused(tmp_path, text):
    (tmp_path / "manifest.json").write_text(text)
    assert "manifest.json" in refused("show", str(tmp_path))


def test_a_broken_table_is_named_when_generating(tmp_path):
    root = Path(mehvar.__file__).parents[1]
    for name in ("models", "generated"):
        shutil.copytree(root / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"))
    table = tmp_path / "models" / "triangle" / "parameters.toml"
    table.write_text(table.read_text().replace('unit = "1/s", default = 3.0', "default = 3.0"))
    text = refused("generate", "triangle", cwd=tmp_path)
    assert "parameters.toml:25: sliding.k_phi.unit is missing" in text
    stale = run("generate", "--check", "triangle", cwd=tmp_path)
    assert stale.returncode == 1
    assert "models/triangle/parameters.toml changed" in stale.stdout
    assert "update it with: mehvar generate triangle" in stale.stdout


def test_a_run_that_leaves_the_disc_ends_with_3_and_its_data(tmp_path):
    """Without its limit the path law goes through a collinear shape: R close to the edge, sampled slowly."""
    arguments = ("--set", "R=0.7", "--set", "hold=1", "--set", "dt_out=0.5", "--set", "k_phi=3")
    done = run("simulate", "triangle", "--controller", "path", *arguments, "--out", "run.nc", cwd=tmp_path)
    assert done.returncode == 3, done.stdout + done.stderr
    assert "rho left the disc" in done.stderr
    saved = mehvar.open_result(tmp_path / "run.nc")
    assert saved.attrs["status"] == "limit"
    assert 0 < saved.attrs["t_stop"] < 35


def test_without_a_compiler_a_run_says_how_to_install_one():
    code = (
        "import sys; sys.modules['ziglang'] = None; import mehvar\n"
        f"from mehvar.__main__ import main; sys.argv[1:] = {SIMULATE}; main()"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env={**os.environ, "PATH": ""})
    assert done.returncode == 2
    assert 'no C compiler found: set $CC, install gcc or clang, or run: pip install "mehvar[cc]"' in done.stderr
    assert "Traceback" not in done.stderr


def test_two_runs_writing_one_file_leave_one_whole_file(tmp_path):
    def write() -> None:
        assert run(*SIMULATE, "--out", "run.nc", cwd=tmp_path).returncode == 0

    threads = [threading.Thread(target=write) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(mehvar.open_result(tmp_path / "run.nc").t) == 101
    assert [p.name for p in tmp_path.iterdir()] == ["run.nc"]


@pytest.mark.soak
def test_doctor_names_what_is_there():
    done = run("doctor")
    assert done.returncode == 0
    assert "C compiler" in done.stdout


@pytest.mark.soak
def test_generate_writes_a_variant_that_runs(tmp_path):
    root = Path(mehvar.__file__).parents[1]
    target = tmp_path / "general"
    done = run(
        "generate", "triangle", "--structure", "masses=general", "--emit", "casadi", "--out", str(target), cwd=root
    )
    assert done.returncode == 0, done.stderr
    assert (target / "triangle_casadi.c").is_file()
    done = run("simulate", str(target), "--controller", "path", "--t-end", "1", "--set", "m2=2", "--set", "m3=3.5")
    assert done.returncode == 0, done.stderr


def test_a_reader_that_leaves_is_no_failure(tmp_path):
    """As in `mehvar show slosh | head -3`; what the command was asked to save is saved."""
    for command in (("show", "slosh"), ("--help",), (*SIMULATE, "--out", "run.nc")):
        reader, writer = os.pipe()
        os.close(reader)
        line = [sys.executable, "-m", "mehvar", *command]
        with os.fdopen(writer, "w") as nobody:
            done = subprocess.run(line, stdout=nobody, stderr=subprocess.PIPE, cwd=tmp_path, timeout=120)
        assert (done.returncode, done.stderr) == (0, b""), command
    assert (tmp_path / "run.nc").is_file()


@pytest.mark.parametrize("where", ["mehvar.cli.list.known_models", "mehvar.cli.app._Commands.parse_args"])
def test_ctrl_c_is_told_in_one_line(where):
    home, name = where.rsplit(".", 1)
    code = (
        "import pkgutil, sys\nfrom mehvar.__main__ import main\n"
        "def pressed(*arguments): raise KeyboardInterrupt\n"
        f"setattr(pkgutil.resolve_name({home!r}), {name!r}, pressed)\nsys.argv[1:] = ['list']\nmain()"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "mehvar: interrupted\n")
