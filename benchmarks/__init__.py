# SPDX-License-Identifier: Apache-2.0
"""Measurements that pages of numbers are made of; each is run as `python -m benchmarks.NAME`."""
