# SPDX-License-Identifier: Apache-2.0
"""Symbolic estimators: factored covariances, and an extended Kalman filter of any system."""
