# SPDX-License-Identifier: Apache-2.0
"""Further laws: quaternion feedback, sliding mode, detumbling by torquers, and a safe mode."""
