# SPDX-License-Identifier: Apache-2.0
"""The commands, each of which parses arguments, calls a package for the work, and prints."""
