# SPDX-License-Identifier: Apache-2.0
"""`python -m mehvar` as a process of its own that need not import the libraries: two seconds of each command.

One process has imported them and nothing of ours that a command could have changed. For each command it forks one that
gets the caller's files, folder and environment. What importing costs and needs is tested by
`tests/mehvar/test_package.py`, signals and limits by tests that start a process of their own.
"""

from __future__ import annotations

import atexit
import contextlib
import functools
import gc
import importlib
import json
import os
import runpy
import select
import shutil
import socket
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

LIBRARIES = (
    *("numpy", "scipy.sparse", "scipy.integrate", "scipy.linalg", "scipy.optimize", "pandas", "xarray", "dask.array"),
    *("pint", "zarr", "h5netcdf", "sympy", "casadi", "mpmath", "pydantic", "jinja2", "typer.main", "rich.console"),
    *("matplotlib.figure", "matplotlib.backends.backend_agg", "PIL.Image", "unicorn", "pyarrow"),
)
CLIENT = """
import json, os, socket, struct, sys
line = socket.socket(socket.AF_UNIX)
line.connect(sys.argv[1])
socket.send_fds(line, [b"."], [0, 1, 2])
text = json.dumps([sys.argv[2:], os.getcwd(), dict(os.environ)]).encode()
line.sendall(struct.pack("<I", len(text)) + text)
(status,) = struct.unpack("<i", line.recv(4))
sys.exit(status)
"""
"""Its exit status is the command's, or 128 and the number of the signal that ended it, as a shell has it."""


@functools.cache
def mehvar() -> list[str]:
    """Return the start of a command line that runs `mehvar` as a process of its own."""
    folder = Path(tempfile.mkdtemp(prefix="mehvar-"))
    place = folder / "socket"
    (folder / "client.py").write_text(CLIENT, encoding="utf-8")
    environment = {**os.environ, "MPLBACKEND": "agg", "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    server = subprocess.Popen(
        [sys.executable, "-m", "tests.commands", place],
        cwd=Path(__file__).parents[1],
        env=environment,
        stdin=subprocess.PIPE,  # whose end is the server's end
        stdout=subprocess.PIPE,
    )
    assert server.stdout is not None
    assert server.stdout.readline() == b"ready\n"
    atexit.register(_end, server, folder)
    return [sys.executable, "-IS", str(folder / "client.py"), str(place)]


def _end(server: subprocess.Popen[bytes], folder: Path) -> None:
    server.communicate()
    shutil.rmtree(folder, ignore_errors=True)


def serve(place: str) -> list[str] | None:
    """Fork a process for each command, in which this returns its arguments, until the standard input ends."""
    for name in LIBRARIES:
        importlib.import_module(name)
    gc.freeze()  # what is shared is not copied for the sake of its counters
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(place)
        listener.listen()
        print("ready", flush=True)
        while 0 not in (ready := select.select([listener, 0], [], [])[0]):
            line, _ = ready[0].accept()
            if os.fork() == 0:
                listener.close()
                return _called(line)
            line.close()
            with contextlib.suppress(ChildProcessError):
                while os.waitpid(-1, os.WNOHANG)[0]:
                    pass
    return None


def _called(line: socket.socket) -> list[str]:
    """Take over a caller's files, folder, environment and arguments; another process sends the exit status."""
    _, files, _, _ = socket.recv_fds(line, 1, 3)
    reader = line.makefile("rb")
    (size,) = struct.unpack("<I", reader.read(4))
    arguments, folder, environment = json.loads(reader.read(size))
    command = os.fork()
    if command:
        status = os.waitstatus_to_exitcode(os.waitpid(command, 0)[1])
        line.sendall(struct.pack("<i", status if status >= 0 else 128 - status))
        os._exit(0)
    line.close()
    for number, file in enumerate(files):
        os.dup2(file, number)
        os.close(file)
    sys.stdin, sys.stdout = open(0, closefd=False), open(1, "w", closefd=False)  # noqa: SIM115
    sys.stderr = open(2, "w", buffering=1, errors="backslashreplace", closefd=False)  # noqa: SIM115
    sys.__stdin__, sys.__stdout__, sys.__stderr__ = sys.stdin, sys.stdout, sys.stderr  # which keep them open
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    sys.path[0:0] = environment.get("PYTHONPATH", "").split(os.pathsep)
    return list(arguments)


if __name__ == "__main__":
    call = serve(sys.argv[1])
    if call is not None:
        sys.argv = ["mehvar", *call]
        runpy.run_module("mehvar", run_name="__main__", alter_sys=True)
