# SPDX-License-Identifier: Apache-2.0
"""A generated folder ready for use: its manifest, functions, parameters."""
