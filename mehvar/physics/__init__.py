# SPDX-License-Identifier: Apache-2.0
"""Physics that the equations of any model must pass, and how many wrong terms these gates notice."""
