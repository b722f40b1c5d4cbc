# SPDX-License-Identifier: Apache-2.0
"""The project against engines that nobody here wrote: not part of `make test`, run by `make validate`."""
