# SPDX-License-Identifier: Apache-2.0
"""Lyapunov laws with thrust and moments, and the constraints of a run."""
