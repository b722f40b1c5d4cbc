# SPDX-License-Identifier: Apache-2.0
"""Gates on the package as a whole: what every part has to keep."""
