# SPDX-License-Identifier: Apache-2.0
"""The Lyapunov laws, how their demands become thrust and moments, and what a run must satisfy."""
