# SPDX-License-Identifier: Apache-2.0
"""Conversions of a generated model for other libraries, which are imported at first use."""
