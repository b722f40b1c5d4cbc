# SPDX-License-Identifier: Apache-2.0
"""Line between host and board: frames, requests, bare packets."""
