# SPDX-License-Identifier: Apache-2.0
"""Efficient form of the equations in `plant`, with O(N) operations and without a large matrix.

`ball` assembles bobs on ball joints from parts. For pendulums described by angles, `hull` has the six equations of
hull and lumped masses, `angles` the contribution of each pendulum, and `linear` the solution.
"""
