# SPDX-License-Identifier: Apache-2.0
"""Functional mock-up units: a generated model as a file that other simulators run."""
