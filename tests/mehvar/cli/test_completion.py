# SPDX-License-Identifier: Apache-2.0
"""Completions of a shell, as `mehvar --install-completion` requests them."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

LINES = {
    "sim": {"simulate"},
    "export ": {"fmu", "web"},
    "simulate sat": {"satellite"},
    "simulate triangle --controller ": {"path", "sliding"},
    "simulate triangle --controller s": {"sliding"},
    "simulate triangle --scenario paper": {"paper", "paper-b"},
    "simulate triangle --controller path --set eta_": set(),
    "simulate triangle --controller sliding --set eta_": {"eta_rho="},
    "simulate triangle --set rt": {"rtol="},
    "simulate slosh --set plan": {"plant="},
    "simulate triangle --input w": {"w1=", "w2=", "w3="},
    "batch triangle --vary the": {"theta=", "theta_0=", "theta_f=", "theta_min=", "theta_star="},
    "batch triangle --controller ": {"path", "sliding"},
    "simulate nothing --controller ": set(),
    "show s": {"satellite", "slosh"},
}


@pytest.mark.parametrize("line", LINES)
@pytest.mark.share(6)
def test_completion(line):
    words = ["mehvar", *line.split(" ")]
    environment = {
        **os.environ,
        "_MEHVAR_COMPLETE": "complete_bash",
        "COMP_WORDS": " ".join(words),
        "COMP_CWORD": str(len(words) - 1),
    }
    command = [sys.executable, "-c", "import sys; sys.argv = ['mehvar']; from mehvar.__main__ import main; main()"]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert set(filter(None, done.stdout.split("\n"))) == LINES[line], done.stderr
    assert not done.stderr
