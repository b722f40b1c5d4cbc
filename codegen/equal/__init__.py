# SPDX-License-Identifier: Apache-2.0
"""Whether two expressions are the same function: one engine, for differences and for ledgers."""
