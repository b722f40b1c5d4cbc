# SPDX-License-Identifier: Apache-2.0
"""Proofs that signs of expressions exclude each other."""
