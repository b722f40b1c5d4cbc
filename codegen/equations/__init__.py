# SPDX-License-Identifier: Apache-2.0
"""The derived equations as a document: written, parsed, and printed for people."""

SCHEMA = 3
"""Version of the schema of equations.json."""
