# SPDX-License-Identifier: Apache-2.0
"""The derived equations of the spacecraft and its pendulums, for people."""
