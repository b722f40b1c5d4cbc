# SPDX-License-Identifier: Apache-2.0
"""`mehvar diff` as a user meets it: in a real git repository, with a small model that is really derived."""

import json
import math
import os
import re
import shlex
import shutil
import subprocess
import xml.etree.ElementTree as ET
from html.parser import HTMLParser

import numpy as np
import pytest
import sympy as sp
from typer.testing import CliRunner

import mehvar
from mehvar import Group, Parameter, Quantity, System
from mehvar.base.manifest import with_digest
from mehvar.cli.app import app
from mehvar.codegen.diff.report import EquationVerdict
from mehvar.codegen.workspace import ROOMS
from mehvar.comparison.html import html_page
from mehvar.comparison.markdown import markdown
from mehvar.comparison.result import Diff, ModelDiff
from tests import commands
from tests.mehvar.browser import chromium, prefer
from tests.mehvar.comparison.projects import CART, ROOT, SIGN, Project
from tests.mehvar.pages import violations


def test_nothing_changed(project):
    status, text = project.diff()
    assert status == 0
    assert "cart: physics the SAME" in text
    assert project.diff("HEAD", "HEAD")[0] == 0


@pytest.fixture(scope="module")
def flipped(committed, tmp_path_factory) -> tuple[Project, ModelDiff]:
    """A project whose spring turned its sign and got another number, and its comparison."""
    project = Project(shutil.copytree(committed, tmp_path_factory.mktemp("flipped") / "tree"))
    project.edit(*SIGN)
    project.edit("default = 8.0", "default = 9.0", "models/cart/parameters.toml")
    return project, project.compared()


def test_a_flipped_sign_is_found_where_it_was_made(flipped):
    _, found = flipped
    assert found.status == "changed"
    assert [equation.name for equation in found.changed][:2] == ["spring", "v_dot"]
    assert (found.added, found.removed, found.equivalent) == ((), (), ())
    assert [change.name for change in found.parameters] == ["k"]
    (source,) = found.comparison.sources
    assert (source.name, source.edits[0].kind) == ("spring", "sign")
    assert source.replayed
    assert source.counterexample.left != source.counterexample.right
    assert {"v_dot", "v'"} <= {e.name for e in found.comparison.of(EquationVerdict.INHERITED)}
    assert str(found).startswith("cart: physics CHANGED")
    assert "eigenvalues" in str(found)


def test_a_pull_request_gets_a_comment_and_a_picture(flipped):
    project, found = flipped
    status = project.git("status", "--porcelain")
    process = project.mehvar("diff", "--out", "comment.md", "--plot", "overlay.png")
    assert process.returncode == 1, process.stderr
    assert process.stdout == "cart: changed\nsaved comment.md\n"
    comment = (project.root / "comment.md").read_text()
    assert comment.splitlines()[2:] == markdown(Diff("", "", (found,))).splitlines()[2:]
    assert "### cart: physics CHANGED" in comment
    assert "```diff\n# in -d v: sign flipped: - became +\n" in comment or "sign flipped" in comment
    assert "| metric | old | new | unit | change |" in comment
    assert comment.count("<details>") == comment.count("</details>") > 0
    assert comment.count("```") % 2 == 0
    assert (project.root / "overlay.png").read_bytes().startswith(b"\x89PNG")
    made = {project.root / name for name in ("comment.md", "overlay.png")}
    assert made <= set(project.root.iterdir())
    for path in made:
        path.unlink()
    assert project.git("status", "--porcelain") == status


def test_the_page_is_whole_and_needs_no_network(flipped):
    text = html_page(Diff("HEAD", "work", (flipped[1],)))
    tags = Tags(text)
    assert all(address.startswith(("#", "data:")) for address in tags.addresses)
    assert not re.search("https?:", text)
    assert len(tags.ids) == len(set(tags.ids))
    card = text[text.index('id="cart-spring"') :]
    card = card[: card.index("</article>")]
    marked = [part.split("</math>")[0] for part in card.split('class="term mark">')[1:]]
    assert len(marked) == 2
    assert ["".join(ET.fromstring(part + "</math>").itertext()).startswith("−") for part in marked] == [True, False]


def test_a_terminal_gets_lines_that_fit(flipped):
    project, found = flipped
    narrow = project.mehvar("diff", FORCE_COLOR="1", COLUMNS="50", TERM="xterm").stdout
    assert "\x1b[" in narrow
    visible = re.sub(r"\x1b\[[0-9;]*m", "", narrow).splitlines()
    assert max(map(len, visible)) <= 50
    assert "".join("".join(visible[1:]).split()) in "".join(str(found).split())


def test_another_form_of_the_same_physics_is_the_same(project):
    project.edit("(spring + FORCE.symbol) / p.mass", "spring / p.mass + FORCE.symbol / p.mass")
    result = project.json(status=0)
    assert not result["differs"]
    verdicts = {equation["name"]: equation["verdict"] for equation in result["equations"]}
    assert verdicts["v_dot"] == "rearranged"
    assert verdicts["spring"] == "same"
    assert result["consequences"] is None


def test_a_parameter_counts_and_its_consequence_is_computed(project):
    project.edit("default = 8.0", "default = 18.0", "models/cart/parameters.toml")
    found = project.compared()
    result = found.to_json()
    assert result["status"] == "parameters changed"
    (change,) = result["parameters"]
    assert (change["name"], change["what"], float(change["old"]), float(change["new"])) == ("k", "value", 8.0, 18.0)
    ((old, new),) = result["consequences"]["eigenvalues"]
    assert complex(*old) == pytest.approx(-0.125 + (4 - 0.125**2) ** 0.5 * 1j)
    assert complex(*new) == pytest.approx(-0.125 + (9 - 0.125**2) ** 0.5 * 1j)
    (loop,) = result["consequences"]["loops"]
    ((old, new),) = loop["eigenvalues"]
    assert (loop["law"], loop["period"], loop["point"]) == ("hold", None, (("x", 0.5),))
    assert complex(*old) == pytest.approx(-0.125 + (4.5 - 0.125**2) ** 0.5 * 1j)
    assert complex(*new) == pytest.approx(-0.125 + (9.5 - 0.125**2) ** 0.5 * 1j)
    (rate,) = result["consequences"]["rates"]
    assert rate["name"] == "v"
    assert rate["unit"] == "m/s^2"
    assert rate["largest"] == pytest.approx(5 * 0.5, rel=0.02)
    assert "eigenvalues under hold at x = 0.5, the rest 0\n" in str(found)
    assert "k  value  " in str(found)


def test_a_changed_law_is_run_in_both_versions_and_has_other_margins(project):
    """The plant is equal: what differs is what the loop does.

    A cart under a spring of its own and a proportional law: |L| = 1 where gain^2 = (k - m w^2)^2 + (d w)^2.
    """
    project.edit("default = 1.0", "default = 28.0", "models/cart/parameters.toml")
    found = project.compared()
    follows = found.to_json()["consequences"]
    (run,) = follows["runs"]["changed"]
    assert (run["law"], run["scenario"], run["old"], run["new"]) == ("hold", "release", "", "")
    assert not follows["rates"]
    (loop,) = follows["loops"]
    ((old, new),) = loop["eigenvalues"]
    assert complex(*old) == pytest.approx(-0.125 + (4.5 - 0.125**2) ** 0.5 * 1j)
    assert complex(*new) == pytest.approx(-0.125 + (18 - 0.125**2) ** 0.5 * 1j)
    assert "release under hold: " in str(found)
    assert "the plant without a law: rates equal at 512 random states" in str(found)
    (change,) = follows["runs"]["margins"]
    for (margin,), gain in ((change["old"], 1.0), (change["new"], 28.0)):
        squares = [u for u in np.roots([4.0, 0.25 - 32.0, 64.0 - gain**2]) if u > 0]
        phase = min(math.atan2(0.5 * u**0.5, 2.0 * u - 8.0) for u in squares)
        assert (margin["input"], margin["gain"]) == ("F", math.inf)
        assert margin["phase"] == pytest.approx(phase)


def test_a_picture_that_cannot_be_is_refused_before_anything_is_compared(project):
    assert "must be a file name that ends in .png" in project.refused("--plot", "overlay.bmp")
    assert "--paper supports neither --plot nor markdown" in project.refused("--paper", "--format", "markdown")


@pytest.mark.soak
def test_revisions_folders_and_trees_give_the_same_answer(project, tmp_path):
    folder = tmp_path / "before"
    shutil.copytree(project.root / "generated" / "cart", folder)
    project.edit("-p.k * x", "-2 * p.k * x")
    expected = project.json(status=1)
    project.generate()
    project.commit("a stiffer spring")
    project.git("tag", "stiff")
    shutil.copytree(project.root, tmp_path / "copy")
    for pair in (
        ("HEAD~1", "HEAD"), ("HEAD~1",), ("main~1", "stiff"), (str(folder), "work"), (str(folder), "generated/cart"),
        (str(folder), "generated"), (str(folder), "."), (str(folder), str(tmp_path / "copy")), ("HEAD~1", "stiff"),
    ):  # fmt: skip
        assert project.json(*pair, status=1) == expected, pair
    assert project.json("HEAD", status=0)["status"] == "same"


def test_the_folder_that_the_command_is_called_in_does_not_matter(project):
    project.edit("-p.k * x", "-2 * p.k * x")
    project.root = project.root / "models" / "cart"
    assert project.json(status=1)["status"] == "changed"


def test_a_tree_may_be_a_folder_of_a_repository(project, tmp_path):
    outer = Project(tmp_path / "outer")
    outer.root.mkdir()
    shutil.move(project.root, outer.root / "inner")
    shutil.rmtree(outer.root / "inner" / ".git")
    outer.git("init", "--quiet")
    outer.commit("all of it")
    inner = Project(outer.root / "inner")
    inner.edit("-p.k * x", "-2 * p.k * x")
    assert inner.json(status=1)["status"] == "changed"


def test_a_revision_with_older_equations_is_derived_from_its_models(project):
    project.edit('"schema": 3', '"schema": 1', "generated/cart/equations.json")
    project.commit("as an older version wrote it")
    project.generate()
    project.edit("-p.k * x", "-2 * p.k * x")
    assert project.json(status=1)["status"] == "changed"
    project.edit("-2 * p.k * x", "p.nonsense * x")
    project.edit('"schema": 3', '"schema": 1', "generated/cart/equations.json")
    project.commit("broken")
    message = project.refused("HEAD", "HEAD~1")
    assert "cart cannot be derived by this version of mehvar: " in message
    assert "nonsense" in message


def older(text: str) -> str:
    """Return a module of models/ as it was when that was a package of its own, and mehvar.base was no folder."""
    text = text.replace("from mehvar.base.display import", "from mehvar.notebook.display import")
    text = re.sub(r"from mehvar\.base\.(?!intervals)", "from mehvar.", text)  # intervals had no module then
    return re.sub(r"^from (?:mehvar\.models|)\.(\w+) import", r"from models.\1 import", text, flags=re.MULTILINE)


def test_a_revision_whose_vocabulary_lacks_a_field_is_refused(project):
    project.edit('"schema": 3', '"schema": 1', "generated/cart/equations.json")
    project.edit('    delay: str = field(default="", kw_only=True)\n', "", "models/system.py")
    for path in (project.root / "models" / "check").glob("*.py"):
        path.write_text(re.sub(r"\b(law|controller)\.delay\b", '""', path.read_text()))
    project.commit("before laws declared delays")
    project.git("checkout", "--quiet", "HEAD~1", "--", ".")
    assert "cart cannot be derived by this version of mehvar: " in project.refused("HEAD", "work")


def test_a_version_from_before_the_one_import_name_is_derived_with_its_own_vocabulary(project, tmp_path):
    project.edit('"schema": 3', '"schema": 1', "generated/cart/equations.json")
    for path in (project.root / "models").rglob("*.py"):
        text = path.read_text()
        path.write_text(older(text) if path.parent.name not in ROOMS else text)
    project.edit("class System(Located):", "class System(Located):\n    before = True", "models/system.py")
    project.edit(
        "    return System(", "    import models.system\n    assert models.system.System is System\n    return System("
    )
    project.edit('name="cart"', 'name="cart" if System.before else ""')
    project.commit("as it was before")
    folder = shutil.copytree(project.root, tmp_path / "folder", ignore=shutil.ignore_patterns(".git"))
    project.git("checkout", "--quiet", "HEAD~1", "--", ".")
    assert project.json("HEAD", "work", status=0)["status"] == "same"
    assert project.json(str(folder), "work", status=0)["status"] == "same"


def test_a_manifest_of_another_version_is_compared(project):
    """Its numbers and what follows from them, with a field that is missing and one that is not known."""
    project.edit('"delay": null,', '"lag": null,', "generated/cart/manifest.json")
    path = project.root / "generated" / "cart" / "manifest.json"
    path.write_text(with_digest(path.read_text()))
    project.commit("as another version wrote it")
    assert project.json("HEAD", "HEAD", status=0)["status"] == "same"
    project.edit("default = 8.0", "default = 18.0", "models/cart/parameters.toml")
    difference = project.json(status=1)
    assert [change["name"] for change in difference["parameters"]] == ["k"]
    assert difference["consequences"]["eigenvalues"]


def test_a_new_model_and_a_lost_one(project):
    shutil.copytree(project.root / "models" / "cart", project.root / "models" / "trolley")
    project.edit('name="cart"', 'name="trolley"', "models/trolley/__init__.py")
    status, text = project.diff()
    assert status == 1
    assert "cart: physics the SAME" in text
    assert "trolley: ADDED" in text
    assert project.diff("--model", "cart")[0] == 0
    assert "trolley: REMOVED" in project.diff("work", "HEAD")[1]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("nonsense",), "'nonsense' is not 'work', no folder with equations.json, and no revision"),
        (("HEAD", "models"), "'models' is not 'work'"),
        (("--model", "cat"), "unknown model 'cat' (from --model): did you mean cart?"),
        (("--format", "xml"), "--format = 'xml': must be text or json or html"),
        (("--paper",), "no published equations"),
        (("HEAD", "--paper"), "--paper compares the current models/ with the paper"),
        (("--out", "missing/page.html"), "'missing/page.html': must be in a folder that exists"),
    ],
)
def test_a_mistake_is_named(project, arguments, message):
    assert message in project.refused(*arguments)


def test_outside_of_a_repository_folders_can_be_compared(project, tmp_path, monkeypatch):
    shutil.rmtree(project.root / ".git")
    monkeypatch.setenv("GIT_CEILING_DIRECTORIES", str(tmp_path))
    assert "is in no git repository" in project.refused()
    assert project.json("generated/cart", "work", status=0)["status"] == "same"


def test_a_mistake_ends_in_one_line_without_a_traceback(project):
    process = project.mehvar("diff", "nonsense")
    assert process.returncode == 2
    assert process.stderr.startswith("mehvar: 'nonsense' is not 'work'")
    assert len(process.stderr.splitlines()) == 1


def test_damaged_equations_are_a_clear_error(project):
    (project.root / "generated" / "cart" / "equations.json").write_text("{")
    assert "is damaged" in project.refused("generated/cart", "HEAD")


class Tags(HTMLParser):
    """Refuses tags that are not closed, and remembers what is referred to."""

    VOID = frozenset({"meta", "link", "br", "mspace", "img"})

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.addresses: list[str] = []
        self.ids: list[str] = []
        self.feed(text)
        self.close()
        assert not self.open

    def handle_starttag(self, tag, attributes):
        if tag not in self.VOID:
            self.open.append(tag)
        self.addresses += [value for name, value in attributes if name in ("href", "src")]
        self.ids += [value for name, value in attributes if name == "id"]

    def handle_endtag(self, tag):
        if tag not in self.VOID:
            assert self.open.pop() == tag


def test_git_shows_the_comparison_as_an_external_diff_and_through_textconv(project):
    (project.root / ".gitattributes").write_text("generated/*/equations.json diff=mehvar\n")
    project.commit("attributes")
    driver = shlex.join(commands.mehvar())
    project.git("config", "diff.mehvar.command", f"{driver} git-diff")
    project.edit(*SIGN)
    project.generate()
    path = "generated/cart/equations.json"
    assert all(word in project.git("diff", "--", path) for word in (path, "spring", "sign"))
    textconv = ("-c", f"diff.mehvar.textconv={driver} git-textconv", "diff", "--no-ext-diff", "-U0", "--", path)
    lines = [line for line in project.git(*textconv).splitlines() if re.match(r"[+-](?![+-]{2})", line)]
    assert sorted(line.split()[-3:] for line in lines) == [["=", "-d", "v"], ["=", "d", "v"]]
    project.commit("turned")
    assert "spring" in project.git("log", "-p", "--ext-diff", "-1", "--", path)
    project.git("rm", "--quiet", path)
    assert "was removed" in project.git("diff", "--cached", "--", path)


def test_a_misprint_of_the_paper_is_named_with_its_correction(project, tmp_path):
    folder = project.root / "papers" / "cart"
    folder.mkdir(parents=True)
    (folder / "__init__.py").touch()
    shutil.copy(CART / "ledger.py", folder)
    process = project.mehvar("diff", "--paper")
    assert process.returncode == 1, process.stderr
    for line in ("cart: 1 hold, 1 differ", "hold  (1)", "differs (2)  acceleration", "misprint: The force pushes."):
        assert line in process.stdout
    printed, correct = (
        next(line for line in process.stdout.splitlines() if word in line) for word in ("printed  ", "assumption  ")
    )
    assert "-F" in printed.replace(" ", "") or "F_s-F" in printed.replace(" ", "")
    assert printed.split()[1:] != correct.split()[1:]
    assert "at " in process.stdout
    shown = json.loads(project.diff("--paper", "--format", "json")[1])
    assert [entry["verdict"] for entry in shown["papers"][0]["entries"]] == ["holds", "differs"]
    status, text = project.diff("--paper", "--model", "cart", "--out", "ledger.html")
    assert status == 1
    assert "cart: 1 hold, 1 differ" in text
    page = (project.root / "ledger.html").read_text(encoding="utf-8")
    assert Tags(page).addresses == ["data:,", "#cart"]
    assert page.count("<math") == 6  # three formulas, and in the change a term and two signs
    assert '<span class="badge">misprint</span> The force pushes. The correction is an assumption.' in page
    with chromium() as browser:
        prefer(browser, prefers_color_scheme="dark")
        browser.get((project.root / "ledger.html").as_uri())
        assert violations(browser) == []


def test_an_error_of_a_ledger_is_told_with_its_line(project):
    folder = project.root / "papers" / "cart"
    folder.mkdir(parents=True)
    (folder / "__init__.py").touch()
    (folder / "ledger.py").write_text("def paper(system):\n    return system.nothing\n")
    process = project.mehvar("diff", "--paper")
    assert process.returncode == 2
    assert process.stderr.startswith("mehvar: papers/cart/ledger.py:2: AttributeError: "), process.stderr


TUTORIAL = (ROOT / "docs" / "tutorials" / "diff.md").read_text(encoding="utf-8")


def shown_file(name: str) -> str:
    """Return a file that the tutorial shows."""
    match = re.search(rf"<!-- file: {re.escape(name)} -->\n```\w+\n(.*?)```", TUTORIAL, re.DOTALL)
    assert match, name
    return match[1]


@pytest.fixture
def command(tmp_path) -> dict[str, str]:
    """An environment in which `mehvar` is the one under test."""
    folder = tmp_path / "bin"
    folder.mkdir()
    (folder / "mehvar").write_text(f'#!/bin/sh\nexec {shlex.join(commands.mehvar())} "$@"\n')
    (folder / "mehvar").chmod(0o755)
    return {"PATH": f"{folder}{os.pathsep}{os.environ['PATH']}"}


@pytest.fixture
def hook(project):
    """The script of the tutorial, staged but not yet committed, and called by git."""
    path = project.root / ".githooks" / "pre-commit"
    path.parent.mkdir()
    path.write_text(shown_file(".githooks/pre-commit"))
    path.chmod(0o755)
    project.git("add", "--all")
    project.git("config", "core.hooksPath", ".githooks")
    return path


COMMIT = ["git", "-c", "user.name=Test", "-c", "user.email=test@example.org", "commit", "--message", "turned"]


@pytest.mark.parametrize("staged", ["models", "generated"])
@pytest.mark.share(2)
def test_the_hook_of_the_tutorial_refuses_what_is_staged_by_half(project, hook, command, staged):
    project.edit(*SIGN)
    project.generate()
    project.git("add", staged)
    stale = attempt(project, COMMIT, command)
    assert stale.returncode == 1
    assert "stale" in stale.stdout + stale.stderr
    project.git("add", "--all")
    kept = attempt(project, COMMIT, command)
    assert kept.returncode == 0, kept.stdout + kept.stderr
    assert "physics CHANGED" in kept.stdout + kept.stderr
    assert not project.diff("HEAD~1", "HEAD")[1].count("stale")


def test_the_hook_takes_the_first_commit_and_leaves_alone_what_is_not_staged(project, hook, command):
    project.edit(*SIGN)
    kept = attempt(project, COMMIT, command)
    assert kept.returncode == 0, kept.stdout + kept.stderr
    assert "physics the SAME" in kept.stdout + kept.stderr
    project.git("checkout", "--quiet", "--", ".")
    project.git("checkout", "--quiet", "--orphan", "first")
    first = attempt(project, COMMIT, command)
    assert first.returncode == 0, first.stdout + first.stderr


def test_the_entry_for_pre_commit_is_the_hook(project, hook, command):
    (entry,) = re.findall(r"entry: (.*)", shown_file(".pre-commit-config.yaml"))
    assert attempt(project, [entry], command).returncode == 0
    project.edit(*SIGN)
    project.git("add", "models")
    assert attempt(project, [entry], command).returncode == 1


@pytest.mark.soak
def test_the_steps_of_the_github_action_run(project, command):
    """Our own steps, as the runner calls them: in one shell that stops at the first failure."""
    text = shown_file(".github/workflows/equations.yml")
    project.edit(*SIGN)
    project.generate()
    project.commit("turned")
    check = re.search(r"run: (mehvar generate --check)\n", text)
    steps = re.search(r"        run: \|\n((?:          .*\n)+)", text)
    assert check is not None
    assert steps is not None
    for script in (check[1], re.sub(r"^ {10}", "", steps[1], flags=re.MULTILINE)):
        process = attempt(project, ["bash", "-e", "-c", script], {**command, "OLD": "HEAD~1"})
        assert process.returncode == 0, process.stderr
    assert sorted(path.name for path in project.root.glob("equations.*")) == [
        "equations.html", "equations.md", "equations.png",
    ]  # fmt: skip
    assert "physics CHANGED" in (project.root / "equations.md").read_text()


def attempt(project: Project, command: list[str], environment: dict[str, str]) -> subprocess.CompletedProcess[str]:
    """Run a command as the tutorial shows it in the project."""
    return subprocess.run(
        command,
        cwd=project.root,
        env={**os.environ, "PYTHONPATH": str(ROOT), **environment},
        capture_output=True,
        text=True,
        timeout=240,
    )


@pytest.mark.soak
def test_a_page_fits_a_telephone_and_one_that_says_the_same_is_small(project, tmp_path):
    project.edit(*SIGN)
    project.diff("--out", "page.html")
    project.diff("HEAD", "HEAD", "--out", "same.html")
    assert (project.root / "same.html").stat().st_size < 100_000
    with chromium() as browser:
        telephone = {"width": 390, "height": 844, "deviceScaleFactor": 1, "mobile": True}
        browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", telephone)
        for name in ("page.html", "same.html"):
            browser.get((project.root / name).as_uri())
            browser.execute_script("document.querySelectorAll('details').forEach(d => d.open = true)")
            assert browser.execute_script("return document.documentElement.scrollWidth") == 390
            assert violations(browser) == []


def test_the_page_of_the_shipped_models_that_says_the_same_is_small(tmp_path):
    """2.3 MB when each unchanged equation was printed."""
    page = tmp_path / "same.html"
    generated = str(ROOT / "generated")
    process = CliRunner().invoke(app, ["diff", generated, generated, "--out", str(page)], catch_exceptions=False)
    assert process.exit_code == 0
    assert page.stat().st_size < 100_000


@pytest.mark.parametrize("bound", ["0", "1/10", "3/10", "6172839/50000000"])
def test_at_a_bound_of_a_parameter_both_sides_have_one_value(bound):
    """Zero divided by zero at a closed bound, also where no double equals the decimal or where it has eight digits."""
    x, low = Group("x", (Quantity("a", "1", "place"),)), sp.Rational(bound)
    k = Parameter("k", "1", "gain", default=1.0, bounds=f"[{float(low)}, 10]")
    p = Group("p", (k, Parameter("tau", "s", "time", default=1.0)))
    above = p.k - low
    rates = (x.a * (above**2 + above) / above, x.a * (above + 1))
    sides = [System(name="m", title="m", states=x, parameters=p, rhs=(rate / p.tau,), initial=(1,)) for rate in rates]
    assert f"they differ at a = 1 and k = {bound}, at a bound" in str(mehvar.diff(*sides))
