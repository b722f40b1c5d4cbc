# SPDX-License-Identifier: Apache-2.0
"""Generated folders that are not of the sources beside them: named, and derived anew or refused; never "the same"."""

import shutil
from types import SimpleNamespace

import pytest

from mehvar.base.errors import InputError
from mehvar.codegen.watch import OURS
from mehvar.comparison.versions.sources import _refuse_files_of_today
from tests.mehvar.comparison.projects import SIGN


def test_a_revision_whose_sources_alone_were_committed_is_derived_anew(project):
    project.edit(*SIGN)
    project.git("add", "models")
    project.git("commit", "--quiet", "--message", "the sources alone")
    result = project.json("HEAD~1", "HEAD", status=1)
    assert result["status"] == "changed"
    (note,) = result["notes"]
    assert note.startswith("generated/cart of HEAD (")
    assert note.endswith("is stale, derived anew: models/cart/__init__.py changed")
    assert project.json("HEAD", "work", status=0)["notes"] == [note]
    assert project.json("HEAD~1", "HEAD~1", status=0)["notes"] == []


def test_a_stale_revision_that_cannot_be_derived_is_refused(project):
    project.edit("-p.k * x", "-p.nonsense * x")
    project.git("add", "models")
    project.git("commit", "--quiet", "--message", "broken")
    assert "cart cannot be derived by this version of mehvar: " in project.refused("HEAD~1", "HEAD")


@pytest.mark.parametrize(("file", "change"), [("extra.py", "is new"), ("scenarios.toml", "changed")])
@pytest.mark.share(2)
def test_every_source_of_a_revision_counts(project, file, change):
    path = project.source.parent / file
    path.write_text((path.read_text() if path.exists() else "") + "\n# more\n")
    project.git("add", "models")
    project.git("commit", "--quiet", "--message", "more")
    assert project.json("HEAD~1", "HEAD", status=0)["notes"][0].endswith(f"models/cart/{file} {change}")


def test_a_helper_beside_models_counts_in_a_revision(project):
    (project.root / "spring.txt").write_text("-1")
    project.edit("    d = Derivation()\n", "    sign = int(HELPER.read_text())\n    d = Derivation()\n")
    project.edit("X = Quantity", "HELPER = Path(__file__).parents[2] / 'spring.txt'\nX = Quantity")
    project.edit("-p.k * x", "sign * p.k * x")
    project.generate()
    project.commit("a helper")
    assert project.json("HEAD~1", "HEAD", status=0)["notes"] == []
    (project.root / "spring.txt").write_text("1")
    project.commit("turned")
    result = project.json("HEAD~1", "HEAD", status=1)
    assert (result["status"], len(result["notes"])) == ("changed", 1)
    assert "spring.txt changed" in result["notes"][0]
    absolute = project.root / "spring.txt"
    project.edit("Path(__file__).parents[2] / 'spring.txt'", f"Path({str(absolute)!r})")
    project.commit("by its absolute path, without generate")
    assert f"reads {absolute}, which is the file of today" in project.refused("HEAD~1", "HEAD")


def test_a_merge_of_sources_with_the_generated_files_of_one_side_is_derived_anew(project):
    project.git("checkout", "--quiet", "-b", "sign")
    project.edit(*SIGN)
    project.generate()
    project.commit("turned")
    project.git("checkout", "--quiet", "main")
    project.edit("default = 8.0", "default = 9.0", "models/cart/parameters.toml")
    project.generate()
    project.commit("stiffer")
    project.git("merge", "--quiet", "--strategy-option", "ours", "--message", "merged", "sign")
    project.git("checkout", "--quiet", "HEAD~1", "--", "generated")
    project.git("commit", "--quiet", "--amend", "--all", "--message", "merged")
    result = project.json("HEAD~1", "HEAD", status=1)
    assert result["status"] == "changed"
    assert "is stale, derived anew: models/cart/__init__.py changed" in result["notes"][0]


def test_a_revision_with_files_of_two_derivations_is_derived_anew(project):
    before = (project.root / "generated" / "cart" / "equations.json").read_text()
    project.edit(*SIGN)
    project.generate()
    (project.root / "generated" / "cart" / "equations.json").write_text(before)
    project.commit("mixed")
    result = project.json("HEAD~1", "HEAD", status=1)
    assert result["status"] == "changed"
    assert "equations.json was changed after generation" in result["notes"][0]


@pytest.mark.parametrize("folder", ["generated/cart", "generated", "."])
@pytest.mark.share(3)
def test_a_generated_folder_beside_other_sources_is_derived_anew(project, folder):
    project.edit(*SIGN)
    result = project.json("HEAD", folder, status=1)
    assert result["status"] == "changed"
    assert result["notes"] == [f"generated/cart of {folder} is stale, derived anew: models/cart/__init__.py changed"]


def test_a_generated_folder_alone_is_taken_as_it_is(project, tmp_path):
    shutil.copytree(project.root / "generated" / "cart", tmp_path / "cart")
    project.edit(*SIGN)
    assert project.json("HEAD", str(tmp_path / "cart"), status=0)["notes"] == []


def test_mehvars_own_files_are_no_files_of_today():
    """In a repository that holds mehvar, today's mehvar derives every version, and reads its templates."""
    revision = SimpleNamespace(of_today=lambda files: next(iter(files), ""))
    _refuse_files_of_today(revision, "HEAD:craft.py", [str(OURS / "codegen" / "code" / "templates" / "model.c.j2")])
    with pytest.raises(InputError, match=r"HEAD:craft.py reads /project/hub.toml, which is the file of today"):
        _refuse_files_of_today(revision, "HEAD:craft.py", ["/project/hub.toml"])
