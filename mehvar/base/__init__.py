# SPDX-License-Identifier: Apache-2.0
"""Modules that all rooms share: errors, names, the schema of generated models, units, the cache."""
