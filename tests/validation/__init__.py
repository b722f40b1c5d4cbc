# SPDX-License-Identifier: Apache-2.0
"""Comparison with independent simulators, run by `make validate`, not by `make test`."""
