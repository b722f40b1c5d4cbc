# SPDX-License-Identifier: Apache-2.0
"""Estimation of parameters from data, tuning of gains, and inputs that lead to a state."""
