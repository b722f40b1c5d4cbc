# SPDX-License-Identifier: Apache-2.0
"""Which tests one process has: those of a module, and all of the papers, which share their runs."""

from __future__ import annotations

from typing import Any

import pytest

PAPERS = "tests/mehvar/papers/"


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Schedule by module, but the papers' tests as one."""
    from xdist.scheduler import LoadScopeScheduling

    class ByModule(LoadScopeScheduling):  # type: ignore[misc]  # xdist has no annotations
        def _split_scope(self, nodeid: str) -> str:
            return PAPERS if nodeid.startswith(PAPERS) else str(super()._split_scope(nodeid))

    return ByModule(config, log) if config.getvalue("dist") == "loadscope" else None
