# SPDX-License-Identifier: Apache-2.0
"""The papers of the shipped models: what each prints, claims and shows, and the functions that check and draw it."""
