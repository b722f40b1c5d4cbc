# SPDX-License-Identifier: Apache-2.0
"""One closed loop: options, problem, integration, results."""
