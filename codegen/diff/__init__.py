# SPDX-License-Identifier: Apache-2.0
"""What changed between two versions of derived equations: mathematics, not text; needs neither SymPy nor CasADi.

`Document.read` reads an equations.json with the manifest beside it, `compare` compares two of them.
"""

from codegen.diff.comparison import compare
from codegen.diff.document import Document, DocumentError

__all__ = ["Document", "DocumentError", "compare"]
