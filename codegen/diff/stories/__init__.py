# SPDX-License-Identifier: Apache-2.0
"""Groups of related changes: one cause, a longer family, the same edit in every axis."""
