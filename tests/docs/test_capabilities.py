# SPDX-License-Identifier: Apache-2.0
"""docs/reference/capabilities.md has the table of the product."""

from docs.site import capabilities


def test_the_page_is_the_table() -> None:
    assert capabilities.PAGE.read_text(encoding="utf-8") == capabilities.page(), "run: python -m docs.site.capabilities"
