# SPDX-License-Identifier: Apache-2.0
"""Evidence about a law in an image: traces from equations to addresses, longest paths, branch coverage."""
