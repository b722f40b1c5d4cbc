# SPDX-License-Identifier: Apache-2.0
"""Groups of related changes: a common cause, a longer family, the same edit in every axis."""
