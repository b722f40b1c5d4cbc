# SPDX-License-Identifier: Apache-2.0
"""The derived equations as a document: written, read back, and printed for people."""

SCHEMA = 3
"""Version of the form of equations.json."""
