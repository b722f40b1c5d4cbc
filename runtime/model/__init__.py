# SPDX-License-Identifier: Apache-2.0
"""A generated model ready for use: manifest, functions, parameters."""
