# SPDX-License-Identifier: Apache-2.0
"""Gates on the whole package."""
