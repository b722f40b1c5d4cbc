# SPDX-License-Identifier: Apache-2.0
"""Evaluation of the runs of a batch: conditions, statistics, sensitivities, requirements."""
