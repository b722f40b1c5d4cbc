# SPDX-License-Identifier: Apache-2.0
"""Estimators in symbols: factors of a covariance, and an extended Kalman filter of any system."""
