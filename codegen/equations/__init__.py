# SPDX-License-Identifier: Apache-2.0
"""Writer, parser and printers of the document of derived equations."""

SCHEMA = 3
"""Version of the schema of equations.json."""
VECTORS = {
    "states": "state", "inputs": "input", "references": "reference", "outputs": "output", "coordinates": "coordinate",
    "noise": "noise", "measured": "measured", "wiener": "wiener", "random_step": "noise of steps",
}  # fmt: skip
"""Fields of a manifest with a vector, and the role of its quantities in equations.json."""
