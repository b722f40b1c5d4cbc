# SPDX-License-Identifier: Apache-2.0
"""Groups of related changes: a common cause, more equal parts, the same edit in every axis."""
