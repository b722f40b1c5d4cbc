# SPDX-License-Identifier: Apache-2.0
"""Laws beside the paper's: quaternion feedback and sliding mode, detumbling by torquers, and a safe mode."""
