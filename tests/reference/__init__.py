# SPDX-License-Identifier: Apache-2.0
"""Independent hand-written computations that the derived models are checked against."""
