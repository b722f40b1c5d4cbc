# SPDX-License-Identifier: Apache-2.0
"""The same problems for other integrators: equations from the tape, and one adapter for each peer."""
