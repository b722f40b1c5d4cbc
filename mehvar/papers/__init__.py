# SPDX-License-Identifier: Apache-2.0
"""Figures and statements of the papers, checked against the models."""
