# SPDX-License-Identifier: Apache-2.0
"""Report of the papers: content computed for each, its pages, and the overview."""
