# SPDX-License-Identifier: Apache-2.0
"""Physical laws that the equations of all models must fulfil, and tests that wrong terms violate these laws.

`machine` evaluates a system by the names of its quantities, `gates` compares values that must agree, `balances` those
of a craft from parts, `signature` needs no declaration, and `mutation` changes the equations term by term. See
docs/explanation/physics-gates.md.
"""
