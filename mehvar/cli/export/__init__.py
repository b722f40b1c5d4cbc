# SPDX-License-Identifier: Apache-2.0
"""`mehvar export`: a model as a file that other programs run."""
