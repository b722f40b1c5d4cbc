# SPDX-License-Identifier: Apache-2.0
"""The paper on adaptive attitude control of a satellite."""
