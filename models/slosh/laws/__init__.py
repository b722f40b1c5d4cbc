# SPDX-License-Identifier: Apache-2.0
"""The Lyapunov laws, their thrust and moments, and the constraints of a run."""
