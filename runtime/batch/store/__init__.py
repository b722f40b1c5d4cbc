# SPDX-License-Identifier: Apache-2.0
"""A batch on disk: its arrays, the records that prove them, the lock of who writes."""
