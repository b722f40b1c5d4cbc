# SPDX-License-Identifier: Apache-2.0
"""Estimation of parameters from data, and tuning of gains."""
