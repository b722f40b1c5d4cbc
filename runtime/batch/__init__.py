# SPDX-License-Identifier: Apache-2.0
"""Many closed loops: what varies, how they are computed, stored and summed up."""
