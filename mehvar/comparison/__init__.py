# SPDX-License-Identifier: Apache-2.0
"""Two versions of the derived equations side by side: sources, verdicts, text, pages."""
