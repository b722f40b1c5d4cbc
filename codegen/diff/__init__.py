# SPDX-License-Identifier: Apache-2.0
"""Mathematical comparison of two versions of derived equations, without SymPy and CasADi.

`Document.read` reads an equations.json with the manifest beside it; `compare` compares two of them.
"""

from ..equations.document import Document, DocumentError
from .comparison import compare

__all__ = ["Document", "DocumentError", "compare"]
