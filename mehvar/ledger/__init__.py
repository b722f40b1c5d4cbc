# SPDX-License-Identifier: Apache-2.0
"""What the papers print against what the models derive, as pages and text."""
