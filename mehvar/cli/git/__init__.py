# SPDX-License-Identifier: Apache-2.0
"""Commands that git calls to show an equations.json."""
