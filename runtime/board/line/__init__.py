# SPDX-License-Identifier: Apache-2.0
"""The line between host and board: frames, requests, bare packets."""
