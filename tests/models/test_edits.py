# SPDX-License-Identifier: Apache-2.0
"""Whatever is edited in a system, it is refused by name, or what is generated of it runs alike in C and in Python.

Short here; `make soak` takes ten thousand edits, and the C of three hundred under sanitizers.
"""

import pytest

from mehvar.models.check import check
from tests.models.campaign import edited, sanitized
from tests.models.edits import cart, turner


@pytest.mark.parametrize("base", [cart, turner])
def test_the_systems_are_in_order(base):
    check(base())


@pytest.mark.parametrize("base", [cart, turner])
@pytest.mark.share(2)
def test_a_few_edits(base, tmp_path):
    outcome = edited(base(), "0", 30, tmp_path)
    assert not outcome.findings, "\n".join(outcome.findings)
    assert 2 < outcome.counts["taken"] < 28


@pytest.mark.parametrize("base", [cart, turner])
@pytest.mark.soak
def test_edited_systems_in_c_under_sanitizers(base, tmp_path):
    outcome = sanitized(base(), "2", 2, tmp_path)
    assert not outcome.findings, "\n".join(outcome.findings)
    assert outcome.counts["watched"] == 2
