# SPDX-License-Identifier: Apache-2.0
"""Dynamic triangle: masses moved by forces of rods, thrusters, and an orbit's gravity gradient."""
