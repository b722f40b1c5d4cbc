# SPDX-License-Identifier: Apache-2.0
"""Emulated board inside this process, and the cost of a step on it."""
