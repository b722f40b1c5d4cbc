# SPDX-License-Identifier: Apache-2.0
"""What a run has otherwise than its scenario: by name, for titles, captions and results."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from mehvar.manifest import Controller, Manifest, Scenario

from .options import OPTIONS, RunOptions

if TYPE_CHECKING:
    from ..model.parameters import Resolved

_MOST = 4
"""Of a title, which is one line: with twice as many it is two."""
_SAME_NUMBERS = ("backend", "max_steps")
"""Options that say who computes and when to give up, not what is computed."""


def changed_values(
    manifest: Manifest, law: Controller, case: Scenario, given: Mapping[str, object], resolved: Resolved
) -> dict[str, float]:
    """Return the given parameters whose values are not the scenario's."""
    parameters = (*manifest.parameters, *law.parameters, *manifest.scenario_parameters)
    defaults = {q.name: q.default for q in parameters}
    plain = {**defaults, **case.values, **case.controllers.get(law.name, {})}
    return {name: resolved.values[name] for name in given if resolved.values[name] != plain[name]}


def changed_options(case: Scenario, options: RunOptions) -> dict[str, float | str]:
    """Return the options that are neither the defaults nor the scenario's."""
    plain = {"t_end": case.duration, "dt_out": case.step}
    changes = options.changes().items()
    return {name: value for name, value in changes if name not in _SAME_NUMBERS and value != plain.get(name)}


def case_text(about: Mapping[str, Any]) -> str:
    """Return what was run, of the attributes of a run or a batch: "paper, theta_0 = 0.3" of the scenario paper."""
    if "campaign" in about:
        campaign = json.loads(about["campaign"])
        plain = {name: row.default for name, row in OPTIONS.items()}
        options = {name: value for name, value in campaign["options"].items() if value != plain.get(name)}
        changed = {**campaign["parameters"], **options, **campaign["initial"]}
    else:
        changed = json.loads(about["changed"])
    return f"{about['scenario']}{_listed(changed)}"


def _listed(changed: Mapping[str, object]) -> str:
    parts = [f"{name} = {v:.6g}" if isinstance(v, float) else f"{name} = {v}" for name, v in changed.items()]
    more = [f"{len(parts) - _MOST} more"] if len(parts) > _MOST else []
    return "".join(f", {part}" for part in [*parts[:_MOST], *more])
