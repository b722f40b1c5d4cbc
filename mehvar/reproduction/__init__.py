# SPDX-License-Identifier: Apache-2.0
"""Vocabulary of the reproduction of a paper: runs, claims, statements, figures and animations."""
