# SPDX-License-Identifier: Apache-2.0
"""Groups of changes that have a common cause, come from additional equal parts, or make the same edit in each axis."""
