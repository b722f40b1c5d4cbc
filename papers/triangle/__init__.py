# SPDX-License-Identifier: Apache-2.0
"""The paper on the planar three-mass triangle."""
