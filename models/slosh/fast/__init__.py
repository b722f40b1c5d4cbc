# SPDX-License-Identifier: Apache-2.0
"""Efficient form of the equations of `plant`: O(N), without a large matrix.

`hull` lumps constant masses and holds the six equations that are solved; `angles` and `ball` say what a pendulum adds
to them; `linear` factorises and solves.
"""
