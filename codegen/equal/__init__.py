# SPDX-License-Identifier: Apache-2.0
"""Engine that decides equality of expressions, for comparisons of versions and for ledgers."""
