# SPDX-License-Identifier: Apache-2.0
"""The paper on a spacecraft with sloshing fuel."""
