# SPDX-License-Identifier: Apache-2.0
"""Groups of related changes: with a common cause, by additional equal parts, or with the same edit in each axis."""
