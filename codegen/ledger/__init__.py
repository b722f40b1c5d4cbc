# SPDX-License-Identifier: Apache-2.0
"""What a paper prints, judged by the derivation."""
