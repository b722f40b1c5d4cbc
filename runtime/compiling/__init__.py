# SPDX-License-Identifier: Apache-2.0
"""From C text to a loaded library: the compiler, the processor, the cache."""
