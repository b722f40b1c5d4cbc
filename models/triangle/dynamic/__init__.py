# SPDX-License-Identifier: Apache-2.0
"""The triangle with masses that forces move: rods that push, thrusters, and the gravity gradient of an orbit."""
