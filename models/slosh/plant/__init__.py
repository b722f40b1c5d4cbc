# SPDX-License-Identifier: Apache-2.0
"""Derived equations of the spacecraft and its pendulums, in readable form."""
