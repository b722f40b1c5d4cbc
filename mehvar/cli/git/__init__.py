# SPDX-License-Identifier: Apache-2.0
"""What git calls to show an equations.json."""
