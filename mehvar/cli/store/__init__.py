# SPDX-License-Identifier: Apache-2.0
"""Commands on the store of a batch."""
