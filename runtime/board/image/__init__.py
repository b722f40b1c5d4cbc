# SPDX-License-Identifier: Apache-2.0
"""Images for boards, built from a generated model, and their contents."""
