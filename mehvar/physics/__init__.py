# SPDX-License-Identifier: Apache-2.0
"""Physics that the equations of any model must pass, and how many wrong terms are noticed.

`machine` evaluates a system by the names of its quantities, `gates` compares what must agree, `units` and `signature`
need no declaration, and `mutation` changes the equations term by term. See docs/explanation/physics-gates.md.
"""
