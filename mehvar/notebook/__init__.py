# SPDX-License-Identifier: Apache-2.0
"""Display of our objects in notebooks, for use in all packages."""
