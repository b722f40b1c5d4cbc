# SPDX-License-Identifier: Apache-2.0
"""The triangle with tethers on reels in place of rods: they pull, go slack, and a spin keeps them taut."""
