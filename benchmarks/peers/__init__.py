# SPDX-License-Identifier: Apache-2.0
"""Problems for other integrators: equations from the list of instructions, and an adapter for each integrator."""
