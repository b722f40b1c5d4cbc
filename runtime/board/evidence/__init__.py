# SPDX-License-Identifier: Apache-2.0
"""What can be said of a law in an image: from equation to address, its longest way, the ways that were taken."""
