# SPDX-License-Identifier: Apache-2.0
"""`python -m mehvar` in a forked process that has imported the libraries, which saves two seconds per command.

One process has imported them, and the rooms of mehvar that read no model. For each command it forks one that gets the
caller's files, folder and environment. Where the caller's PYTHONPATH leads to another copy of mehvar, the fork forgets
these rooms. What importing costs and needs is tested by `tests/mehvar/test_package.py`, signals and limits by
tests that start a process of their own.

A command derives models and judges papers in further processes, by `python -P` or by multiprocessing: `python` is a
program that forks these as well, and is any other Python for whatever else it is asked. The processes of one run share
its server.
"""

from __future__ import annotations

import atexit
import contextlib
import functools
import gc
import importlib
import itertools
import marshal
import multiprocessing.spawn
import os
import pkgutil
import runpy
import select
import shutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
import traceback
from pathlib import Path
from typing import Any, NoReturn

LIBRARIES = (
    *("numpy", "scipy.sparse", "scipy.integrate", "scipy.linalg", "scipy.optimize", "pandas", "xarray", "dask.array"),
    *("pint", "zarr", "h5netcdf.legacyapi", "sympy", "sympy.combinatorics", "sympy.tensor", "casadi", "mpmath"),
    *("pydantic.json_schema", "pydantic.type_adapter", "jinja2", "typer.main", "typer._adapters", "tomllib"),
    *("rich.console", "rich.progress", "rich.table", "matplotlib.figure", "matplotlib.backends.backend_agg"),
    *("PIL.Image", "unicorn", "pyarrow", "distributed"),  # xarray imports the last to write a file
)
ROOMS = ("base", "cli", "runtime", "pictures", "formats")
"""Packages that are imported in advance; a derivation must import `models` itself, because it records the imports."""
COLD = sys.executable
"""A Python that has imported nothing."""
MOST = 64
"""Number of files that a caller passes: 3, and 2 of multiprocessing."""
PATIENCE = 120.0
"""Seconds for the libraries, where many processes start at once."""
_ADOPTED = ""
CLIENT = """#!{python} -IS
import _socket, marshal, os, sys  # no more: it is as quick as a Python can be
words = sys.argv[1:]
warm = words[:2] in (["-P", "-m"], ["-P", "-c"]) or words[-1:] == ["--multiprocessing-fork"]
if not warm:
    os.execv({python!r}, [{python!r}, *words])
line = _socket.socket(_socket.AF_UNIX)
line.connect({place!r})
files = [number for number in range(256) if number != line.fileno() and os.path.exists(f"/proc/self/fd/{{number}}")]
rights = b"".join(number.to_bytes(4, sys.byteorder) for number in files)
line.sendmsg([b"."], [(_socket.SOL_SOCKET, _socket.SCM_RIGHTS, rights)])
text = marshal.dumps([words, files, os.getcwd(), dict(os.environ)])
line.sendall(len(text).to_bytes(4, "little") + text)
sys.exit(int.from_bytes(line.recv(4) or b"\\1\\0\\0\\0", "little", signed=True))
"""
"""Command whose exit status is the forked command's, or 128 plus the number of the signal that ended it."""


def mehvar() -> list[str]:
    """Return the beginning of a command line that runs `mehvar` in a separate process."""
    return [python(), "-P", "-m", "mehvar"]


def python() -> str:
    """Return the path of the program, when its server is ready."""
    program = _ADOPTED or started()
    end = time.monotonic() + PATIENCE
    while not Path(program).with_name("socket").exists():
        assert time.monotonic() < end, "the server of commands does not begin"
        time.sleep(0.02)
    return program


def adopt(program: str) -> None:
    """Use the program of the process that started this one."""
    global _ADOPTED
    _ADOPTED = program


@functools.cache
def started() -> str:
    """Return the path of the program, whose server ends with this process and may still be importing."""
    folder = Path(tempfile.mkdtemp(prefix="mehvar-"))
    place, program = folder / "socket", folder / "python"
    program.write_text(CLIENT.format(python=COLD, place=str(place)), encoding="utf-8")
    program.chmod(0o700)
    if all(name in sys.modules for name in LIBRARIES) and "mehvar" not in sys.modules:
        _fork(place)
        return str(program)
    environment = {**os.environ, "MPLBACKEND": "agg", "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    server = subprocess.Popen(
        [COLD, "-m", "tests.commands", place],
        cwd=Path(__file__).parents[1],
        env=environment,
        stdin=subprocess.PIPE,  # the server ends when this pipe closes
    )
    atexit.register(_end, server, folder)
    return str(program)


def _fork(place: Path) -> None:
    """Serve from a fork of this process, which has imported the libraries; the server ends with this process."""
    its_input, held = os.pipe()
    sys.stdout.flush()
    if os.fork() == 0:
        os.dup2(its_input, 0)
        os.close(its_input)
        os.close(held)
        try:
            main(str(place))
        except BaseException:  # the copy of the caller must end here
            traceback.print_exc()
        finally:
            os._exit(1)
    os.close(its_input)


def _end(server: subprocess.Popen[bytes], folder: Path) -> None:
    server.communicate()
    shutil.rmtree(folder, ignore_errors=True)


def load() -> None:
    """Import the installed libraries and the packages of mehvar, and compile the templates of derivations."""
    for name in LIBRARIES:
        with contextlib.suppress(ModuleNotFoundError):
            importlib.import_module(name)
    for room in ROOMS:
        package = importlib.import_module(f"mehvar.{room}")
        for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            with contextlib.suppress(ModuleNotFoundError):
                importlib.import_module(module.name)
    templates = importlib.import_module("mehvar.codegen.templates")
    for folder in sorted(Path(importlib.import_module("mehvar.codegen").__path__[0]).glob("*/templates")):
        environment = templates.text_environment(folder)
        for name in environment.list_templates():
            environment.get_template(name)
    sys.dont_write_bytecode = True  # of what a test may edit within a second


def serve(place: str) -> list[str] | None:
    """Fork a process for each command until the standard input ends; in each fork, return the arguments."""
    gc.disable()
    load()
    os.fsync = lambda _: None  # as tests/conftest.py
    sys.executable = str(Path(place).with_name("python"))
    multiprocessing.spawn.set_executable(sys.executable)
    gc.freeze()  # what is shared is not copied for the sake of its counters
    gc.set_threshold(100_000, 20, 100)
    gc.enable()
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(f"{place}.new")
        listener.listen()
        Path(f"{place}.new").rename(place)  # where it is, it answers
        heard, told = os.pipe2(os.O_NONBLOCK)
        signal.set_wakeup_fd(told)
        usual = signal.signal(signal.SIGCHLD, lambda *_: None)
        lines = dict[int, socket.socket]()
        while 0 not in (ready := select.select([listener, heard, 0], [], [])[0]):
            if heard in ready:
                os.read(heard, 4096)
                _answer(lines)
            if listener in ready:
                line, _ = listener.accept()
                try:
                    files, request = _request(line)
                except (OSError, EOFError, ValueError, struct.error):  # a caller that was ended
                    line.close()
                    continue
                command = os.fork()
                if command == 0:
                    signal.set_wakeup_fd(-1)
                    signal.signal(signal.SIGCHLD, usual)
                    for other in (listener, line, *lines.values()):
                        other.detach()  # their numbers become those of the caller's files
                    return _called(files, *request)
                lines[command] = line
                for number in files:
                    os.close(number)  # a pipe ends when the command closes it
    return None


def _answer(lines: dict[int, socket.socket]) -> None:
    """Send the exit status of each command that has ended."""
    while lines and (ended := os.waitpid(-1, os.WNOHANG))[0]:
        status = os.waitstatus_to_exitcode(ended[1])
        with lines.pop(ended[0]) as line, contextlib.suppress(OSError):  # a caller that was ended does not wait
            line.sendall(struct.pack("<i", status if status >= 0 else 128 - status))


def _request(line: socket.socket) -> tuple[list[int], list[Any]]:
    """Return a caller's files, and its arguments, the numbers of the files there, folder and environment."""
    _, files, _, _ = socket.recv_fds(line, 1, MOST)
    with line.makefile("rb") as reader:
        (size,) = struct.unpack("<I", reader.read(4))
        return files, marshal.loads(reader.read(size))


def _called(
    files: list[int], arguments: list[str], numbers: list[int], folder: str, environment: dict[str, str]
) -> list[str]:
    """Adopt a caller's files, folder and environment; return its arguments."""
    _number(dict(zip(numbers, files, strict=True)))
    sys.stdin, sys.stdout = open(0, closefd=False), open(1, "w", closefd=False)  # noqa: SIM115
    sys.stderr = open(2, "w", buffering=1, errors="backslashreplace", closefd=False)  # noqa: SIM115
    sys.__stdin__, sys.__stdout__, sys.__stderr__ = sys.stdin, sys.stdout, sys.stderr  # which keep them open
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    sys.path[0:0] = places = environment.get("PYTHONPATH", "").split(os.pathsep)
    if any(_has_another(Path(place)) for place in places):
        for name in [name for name in sys.modules if name.partition(".")[0] == "mehvar"]:
            del sys.modules[name]
    return arguments


def _has_another(place: Path) -> bool:
    """Return True for a folder with another copy of mehvar than this one."""
    return (place / "mehvar").is_dir() and not place.samefile(Path(__file__).parents[1])


def _number(files: dict[int, int]) -> None:
    """Give the caller's files their numbers, and close all others."""
    high = max((*files, *files.values())) + 1
    apart = {number: high + k for k, number in enumerate(files)}
    for number, file in files.items():
        os.dup2(file, apart[number])
    for number, file in apart.items():
        os.dup2(file, number)
    for number in {*range(2 * high)} - {*files}:
        with contextlib.suppress(OSError):
            os.close(number)


def run(words: list[str]) -> None:
    """Run a command line as Python does: flags, then `-m mehvar ...` or `-c TEXT ...`."""
    kind, what, *arguments = itertools.dropwhile(lambda word: word not in ("-m", "-c"), words)
    if kind == "-m":
        sys.argv = [what, *arguments]
        runpy.run_module(what, run_name="__main__", alter_sys=True)
    else:
        sys.argv = ["-c", *arguments]
        exec(compile(what, "<string>", "exec"), vars(sys.modules["__main__"]))


def _exit(code: object) -> NoReturn:
    """End like the interpreter, but without unloading the libraries, which saves 0.1 s."""
    if code is not None and not isinstance(code, int):
        print(code, file=sys.stderr)
    threading._shutdown()  # type: ignore[attr-defined]
    atexit._run_exitfuncs()
    with contextlib.suppress(BrokenPipeError):
        sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code & 0xFF if isinstance(code, int) else code is not None)


def main(place: str) -> NoReturn:
    """Serve, and run a command in each fork."""
    call = serve(place)
    if call is not None:
        try:
            run(call)
        except SystemExit as end:
            _exit(end.code)
    _exit(0)


if __name__ == "__main__":
    main(sys.argv[1])
