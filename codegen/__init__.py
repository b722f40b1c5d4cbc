# SPDX-License-Identifier: Apache-2.0
"""Code generation: SymPy expressions become CasADi graphs, then one list of instructions, printed as C and Python.

`generate.generate` goes through these stages for a model that changed:

1. `workspace.load_model`. In: a folder models/MODEL. Out: its Python module. `loaded` and `watch` record the files and
   variables that it reads, from which a later call decides whether anything changed.
2. `generate.system_of`. In: the module and its structural choices. Out: a `mehvar.models.System`, checked by
   `mehvar.models.check`, in which clock, sample counts, mass matrix and arrays have become states and entries.
3. `functions.verify`. In: the system. Out: nothing, or an error where CasADi's functions or an efficient form differ
   from the derived equations.
4. `functions.graphs`. In: the system. Out: a CasADi graph for each function: right-hand side, laws, closed loops,
   initial state, outputs, and their derivatives by algorithmic differentiation.
5. `code.files.printed_functions`. In: the graphs. Out: the instructions of each (`code.tape`), split into a part that
   depends only on parameters and the rest (`code.split`), with names from the model (`code.labels`) and loops over
   equal parts (`code.loops`).
6. `manifest`. In: system and functions. Out: a `mehvar.base.manifest.Manifest`, all that the runtime knows of a model.
7. `code.files.code_files` and `equations`. In: manifest, functions, system. Out: texts of C, header and Python files,
   and the equations for readers and for comparisons.
8. `generate.write`. In: the texts. Out: generated/MODEL, the manifest last, so that an interrupted write is noticed.

Beside them, `diff` compares the equations of two versions, `equal` decides whether two expressions are equal, and
`ledger` compares printed equations with derived ones. `diff` and `equal` read equations.json, without SymPy and CasADi.
"""
