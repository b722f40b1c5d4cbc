# SPDX-License-Identifier: Apache-2.0
"""Changes that belong together: one cause, a longer family, the same edit in every axis."""
