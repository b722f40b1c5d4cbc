# SPDX-License-Identifier: Apache-2.0
"""The page of the papers' equations, in a browser."""

import pytest

from mehvar.reproduction.ledger_page import paper_page
from tests import derived
from tests.mehvar.browser import chromium
from tests.mehvar.pages import cut_on_paper


@pytest.mark.parametrize("model", sorted(derived.REPRODUCED, reverse=True))  # that which other tests judge
@pytest.mark.share(3)
def test_nothing_of_a_ledger_is_cut_on_paper(model, tmp_path):
    """It has no script that makes formulas smaller: long ones break into lines."""
    file = tmp_path / "ledger.html"
    file.write_text(paper_page(derived.verdicts(model)), encoding="utf-8")
    with chromium() as browser:
        browser.get(file.as_uri())
        browser.execute_script("document.querySelectorAll('details').forEach((part) => { part.open = true; })")
        assert cut_on_paper(browser) == []
