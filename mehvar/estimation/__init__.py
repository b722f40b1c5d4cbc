# SPDX-License-Identifier: Apache-2.0
"""Estimation of parameters from data, tuning of gains, inputs that lead to a state, and margins of loops."""
