# SPDX-License-Identifier: Apache-2.0
"""Points at which verdicts are tested again: on thresholds, where a model allows them, and many in double precision."""
