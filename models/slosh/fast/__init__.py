# SPDX-License-Identifier: Apache-2.0
"""Efficient form of the equations of `plant`: O(N), without a large matrix.

`ball` assembles bobs on ball joints from parts. For pendulums by angles `hull` lumps constant masses and holds the six
equations that are solved, and `angles` says what a pendulum adds to them; `linear` factorises and solves.
"""
