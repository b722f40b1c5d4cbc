# SPDX-License-Identifier: Apache-2.0
"""Symbolic estimators for any system: extended Kalman filter, sigma-point filter, factored covariances."""
