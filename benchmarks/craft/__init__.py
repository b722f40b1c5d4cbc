# SPDX-License-Identifier: Apache-2.0
"""One craft of 16 degrees of freedom in mehvar, Basilisk and Drake."""
