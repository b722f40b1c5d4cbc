# SPDX-License-Identifier: Apache-2.0
"""Writer, parser and printers of the document of derived equations."""

SCHEMA = 3
"""Version of the schema of equations.json."""
