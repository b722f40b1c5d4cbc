# SPDX-License-Identifier: Apache-2.0
"""Named vectors of a model and constants of its header. Generation writes them; a run checks them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from mehvar.base.manifest import Manifest, Parameter, Quantity
from mehvar.base.names import identifier


@dataclass(frozen=True)
class Vector:
    """A vector whose elements have names in the header and in the Python module.

    Attributes
    ----------
    title : str
        Its title in words.
    prefix, constant : str
        Prefix of its elements' constants in C, and Python name of the tuple with their names.
    quantities : sequence of Quantity or Parameter
        Its elements.
    """

    title: str
    prefix: str
    constant: str
    quantities: Sequence[Quantity | Parameter]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the elements."""
        return tuple(q.name for q in self.quantities)


def vectors(manifest: Manifest) -> list[Vector]:
    """Return the named vectors of a model."""
    result = [
        Vector("state x", "X", "STATES", manifest.states),
        Vector("input u", "U", "INPUTS", manifest.inputs),
        Vector("reference r", "R", "REFERENCES", manifest.references),
        Vector("output y", "Y", "OUTPUTS", manifest.outputs),
        Vector("plant parameters p", "P", "PARAMETERS", manifest.parameters),
        Vector("scenario parameters s", "S", "SCENARIO_PARAMETERS", manifest.scenario_parameters),
    ]
    if manifest.coordinates:
        result.append(Vector("regular coordinates q", "Q", "COORDINATES", manifest.coordinates))
    for law in manifest.controllers.values():
        upper = identifier(law.name).upper()
        title = f"parameters c of the law {law.name}"
        result.append(Vector(title, f"{upper}_C", f"{upper}_PARAMETERS", law.parameters))
        if law.memory:
            result.append(Vector(f"memory z of the law {law.name}", f"{upper}_Z", f"{upper}_MEMORY", law.memory))
    return result


def constants(manifest: Manifest) -> list[tuple[str, int]]:
    """Return the constants of the header: positions and lengths of vectors, sizes in each function."""
    model = manifest.model.upper()
    result = []
    for vector in vectors(manifest):
        result += [(f"{model}_{vector.prefix}_{name.upper()}", k) for k, name in enumerate(vector.names)]
        result.append((f"{model}_N{vector.prefix}", len(vector.names)))
    for f in manifest.functions.values():
        result += [(f"{model}_{identifier(f.name)}_N{a.name}".upper(), a.size) for a in (*f.arguments, *f.results)]
    return result
