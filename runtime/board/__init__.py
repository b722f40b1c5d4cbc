# SPDX-License-Identifier: Apache-2.0
"""Sampled laws on a microcontroller: firmware in C, its build, the link to it, and runs with the law on the board."""
