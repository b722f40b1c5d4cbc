# SPDX-License-Identifier: Apache-2.0
"""Emulated board within this process, and the cost of a step on it."""
