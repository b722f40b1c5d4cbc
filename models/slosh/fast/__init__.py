# SPDX-License-Identifier: Apache-2.0
"""The same equations in the form that machines evaluate: O(N), without a large matrix."""
