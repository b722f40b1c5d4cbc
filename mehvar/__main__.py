# SPDX-License-Identifier: Apache-2.0
"""The `mehvar` command: exit 0 done, 1 the answer is no, 2 bad usage or input, 3 the run itself failed."""

from __future__ import annotations

import sys
from pathlib import Path

from mehvar.ending import fail, interruptible, let_readers_leave, warn_in_a_line


def main() -> None:
    """Run the command line; a user's mistake ends in one message, never in a traceback."""
    with interruptible():
        _leave_working_folder()
        let_readers_leave()
        warn_in_a_line()
        _run()


def _run() -> None:
    from mehvar.cli import app
    from runtime.errors import BuildError, InputError

    try:
        app()
    except InputError as error:
        fail(error, 2)
    except BuildError as error:
        fail(error, 3)
    except ModuleNotFoundError as error:
        fail(f"the package {error.name} is missing: pip install {error.name} (mehvar doctor lists them all)", 2)
    except OSError as error:
        where = f" {error.filename}" if error.filename else ""
        fail(f"{error.strerror or error}{where}", 2)
    except (ValueError, LookupError) as error:
        if not _is_model_mistake(error):
            raise
        fail(error, 2)


def _leave_working_folder() -> None:
    """Keep `python -m mehvar` from importing the user's own folders models, runtime, codegen or generated."""
    here = Path.cwd()
    if not sys.flags.safe_path and sys.path[0] == str(here) and here != Path(__file__).parents[1]:
        del sys.path[0]


def _is_model_mistake(error: Exception) -> bool:
    """Tell a mistake in a model's text, which derivation reports, from a fault of our own."""
    mistakes = {
        "models.quantities": "ModelError",
        "codegen.tree": "GenerateError",
        "codegen.lower": "LoweringError",
        "codegen.tape": "TapeError",
        "codegen.precise": "UnknownFunctionError",
        "codegen.verify": "VerificationError",
    }
    return any(
        home in sys.modules and isinstance(error, getattr(sys.modules[home], name)) for home, name in mistakes.items()
    )


if __name__ == "__main__":
    main()
