# SPDX-License-Identifier: Apache-2.0
"""The two versions of a comparison as generated folders."""
