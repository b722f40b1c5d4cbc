# SPDX-License-Identifier: Apache-2.0
"""Evidence for a law in an image: traces from equations to addresses, longest paths, and branch coverage."""
