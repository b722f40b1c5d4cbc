# SPDX-License-Identifier: Apache-2.0
"""Conversions of a generated model for other libraries; each library is imported at first use."""
