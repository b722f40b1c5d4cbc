# SPDX-License-Identifier: Apache-2.0
"""Papers of the shipped models: printed equations, claims and figures, and the functions that check and draw them."""
