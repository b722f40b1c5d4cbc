# SPDX-License-Identifier: Apache-2.0
"""Images for boards: build and contents."""
