# SPDX-License-Identifier: Apache-2.0
"""Benchmarks, which write the pages of numbers; run each as `python -m benchmarks.NAME`."""
