# SPDX-License-Identifier: Apache-2.0
"""A closed-loop run: options, problem, integration, results."""
