# SPDX-License-Identifier: Apache-2.0
"""The `mehvar` command.

Exit status: 0 for success, 1 for a negative answer, 2 for bad usage or input, 3 for a failed run.
"""

from __future__ import annotations

import gc
import sys

from mehvar.terminal import fail, ignore_closed_output, interruptible, print_version, shorten_warnings

_PACKAGES = {"elftools": "pyelftools", "serial": "pyserial"}
"""Names of packages that differ from the name of their module."""


def main() -> None:
    """Run the command line; a user's mistake ends in one message, never in a traceback.

    Imports create no garbage, and the end of the process frees everything. Fewer collections, and none at the end, take
    a quarter of the processor time of a short command (`mehvar simulate triangle`: 0.38 to 0.29 s).
    """
    gc.set_threshold(100_000, 20, 100)
    try:
        with interruptible():
            ignore_closed_output()
            shorten_warnings()
            if sys.argv[1:] == ["--version"]:  # before anything of the commands is imported
                print_version()
            else:
                _run()
    finally:
        gc.freeze()


def _run() -> None:
    """Run the command; an expected error ends with its message and exit status, without a traceback."""
    from mehvar.base.errors import MehvarError, is_shortage
    from mehvar.cli.app import app

    try:
        app()
    except MehvarError as error:
        fail(error, error.exit_status)
    except (MemoryError, RuntimeError) as error:
        if not is_shortage(error):
            raise
        fail(f"not enough memory{f': {error}' if str(error) else ''}", 3)
    except ModuleNotFoundError as error:
        fail(f"the module {error.name} is missing{_how_to_install(error.name or '')}", 2)
    except OSError as error:
        where = f" {error.filename}" if error.filename else ""
        fail(f"{error.strerror or error}{where}", 2)


def _how_to_install(module: str) -> str:
    """Return the command that installs one of mehvar's dependencies; empty for other packages."""
    from mehvar.base.versions import extra_of, required

    package = module.partition(".")[0]
    if extra := extra_of(_PACKAGES.get(package, package)):
        return f': pip install "mehvar[{extra}]"'
    return f": pip install {package} (mehvar doctor lists them all)" if package in required() else ""


if __name__ == "__main__":
    main()
