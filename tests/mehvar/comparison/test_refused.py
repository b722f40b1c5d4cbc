# SPDX-License-Identifier: Apache-2.0
"""A run that neither version makes is not called the same."""

import shutil
from pathlib import Path

import pytest

from mehvar.base.errors import InputError
from mehvar.base.manifest import FILE, with_digest
from mehvar.cli.diff import command
from mehvar.comparison.effects import refused_runs
from mehvar.comparison.runs import runs

PENDULUM = Path(__file__).parents[2] / "runtime" / "pendulum"


def test_what_both_versions_refuse_is_told_as_not_run(tmp_path: Path) -> None:
    folder = tmp_path / "pendulum"
    shutil.copytree(PENDULUM, folder)
    text = (folder / FILE).read_text().replace('"angle_0": 0.8', '"angle_0": 3.5')
    (folder / FILE).write_text(with_digest(text))
    result, overlay = runs(folder, folder, {})
    assert overlay is None
    assert {(law, scenario) for law, scenario, _ in result.refused} == {("pd", "stiff"), ("p-sum", "stiff")}
    assert not {(law, scenario) for law, scenario, _ in result.refused} & set(result.same)
    assert any(line.startswith("not run, as both refuse it: stiff under pd: ") for line in refused_runs(result))


@pytest.mark.parametrize(("form", "file"), [("json", "a.html"), ("html", "a.json"), ("text", "a.md")])
def test_a_file_holds_what_its_name_says(form: str, file: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=f"--format = '{form}': must be left out or .*, as .*{file} ends"):
        command(str(PENDULUM), str(PENDULUM), form=form, out=tmp_path / file)
    assert not (tmp_path / file).exists()
