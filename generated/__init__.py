# SPDX-License-Identifier: Apache-2.0
"""What code generation wrote, a folder a model; committed so that reviewers see what a change of model does."""
