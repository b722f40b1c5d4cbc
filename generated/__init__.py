# SPDX-License-Identifier: Apache-2.0
"""Generated code, a folder for each model; committed so that reviewers see the effect of a change."""
