# SPDX-License-Identifier: Apache-2.0
"""Points that test verdicts again: on thresholds, within a model's conditions, and many in double precision."""
