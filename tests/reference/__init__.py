# SPDX-License-Identifier: Apache-2.0
"""Independent hand-written computations for checks of the derived models."""
