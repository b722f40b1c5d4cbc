# SPDX-License-Identifier: Apache-2.0
"""Sampled laws on a microcontroller: firmware, build, link, and runs with the law on a board."""
