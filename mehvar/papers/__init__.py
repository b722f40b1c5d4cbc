# SPDX-License-Identifier: Apache-2.0
"""What the papers show and say, checked against the models."""
