# SPDX-License-Identifier: Apache-2.0
"""Values of parameters from data, and gains from a cost."""
