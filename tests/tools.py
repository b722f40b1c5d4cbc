# SPDX-License-Identifier: Apache-2.0
"""Programs that some tests need and that do not come from PyPI; `.ci/run` installs them all."""

import shutil

import pytest

_PACKAGES = {
    "arm-none-eabi-gcc": "gcc-arm-none-eabi libnewlib-arm-none-eabi",
    "arduino-builder": "arduino-builder arduino-core-avr arduino-ctags",
    "avr-gcc": "gcc-avr avr-libc",
}


def needs(*programs: str) -> pytest.MarkDecorator:
    """Skip a test if a program is missing, with its install command."""
    missing = [program for program in programs if shutil.which(program) is None]
    how = " ".join(_PACKAGES.get(program, program) for program in missing)
    return pytest.mark.skipif(bool(missing), reason=f"no {', '.join(missing)}: apt install {how}")
