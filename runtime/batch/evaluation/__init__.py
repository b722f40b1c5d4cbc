# SPDX-License-Identifier: Apache-2.0
"""What the runs of a batch say: conditions, statistics, sensitivities, requirements."""
