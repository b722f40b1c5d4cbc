# SPDX-License-Identifier: Apache-2.0
"""Packages of a law for the build systems and frameworks of other projects."""
