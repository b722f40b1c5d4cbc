# SPDX-License-Identifier: Apache-2.0
"""A board inside this process, and what a step costs on it."""
