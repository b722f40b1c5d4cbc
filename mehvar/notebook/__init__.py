# SPDX-License-Identifier: Apache-2.0
"""What a notebook shows of our objects; every room may use it."""
