# SPDX-License-Identifier: Apache-2.0
"""The shipped systems, derived a second time from parts."""
