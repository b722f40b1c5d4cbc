# SPDX-License-Identifier: Apache-2.0
"""Generated folders: same sources, same bytes; stale files are named with their cause; nothing is half written."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from mehvar.base.manifest import files_on_first_use, manifest_text, read_manifest
from mehvar.codegen import generate as generation
from mehvar.codegen.generate import (
    GenerateError,
    Tree,
    check,
    derive,
    find_tree,
    generate,
    installed_tree,
    locked,
    write,
)
from mehvar.codegen.new_numbers import shapes
from mehvar.codegen.workspace import ROOMS
from mehvar.models.quantities import ModelError

ROOT = installed_tree().root
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT)}
MODELS = installed_tree().models
LARGEST = "slosh"
"""Model that takes as long as the others together."""


@pytest.fixture
def tree(tmp_path):
    """A copy of models/ and generated/ that a test may change."""
    for name in ("models", "generated"):
        shutil.copytree(ROOT / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"))
    return Tree(tmp_path)


def python(code: str, folder: Path, *arguments: str, **environment: str) -> str:
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT), "SYMPY_CACHE_SIZE": "1000", **environment},  # SymPy's own size
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout


@pytest.mark.soak
def test_who_derives_changes_nothing(tree):
    """A text beside the models that derives them asks nothing in their name, nor does a console script there."""
    program = tree.root / "bin" / "derive"
    program.parent.mkdir()
    program.write_text(
        "from pathlib import Path\n"
        "from mehvar.codegen.generate import find_tree, generate\n"
        "generate(find_tree(Path.cwd()), 'satellite')"
    )
    manifest = tree.root / "generated" / "satellite" / "manifest.json"
    before = manifest.read_bytes()
    manifest.unlink()
    python("import runpy; runpy.run_path('bin/derive')", tree.root, PYTHONPATH=f"{tree.root}:{ROOT}")
    assert manifest.read_bytes() == before


def test_folders_inside_the_rooms_are_sources_too():
    """An edit of an orbit or a sensor left the satellite up to date: only files directly in a room were recorded."""
    rooms = {path.relative_to(ROOT).as_posix() for room in ROOMS for path in (ROOT / "models" / room).rglob("*.py")}
    assert any(name.count("/") > 2 for name in rooms)
    assert rooms <= installed_tree().sources("satellite").keys()


def generate_in(tree: Tree) -> None:
    """Generate in a process of its own: this one has imported the models of another tree."""
    code = (
        "from pathlib import Path\n"
        "from mehvar.codegen.generate import find_tree, generate\n"
        "generate(find_tree(Path.cwd()), 'triangle')"
    )
    python(code, tree.root, PYTHONPATH=f"{tree.root}:{ROOT}")


@pytest.mark.parametrize("model", [m if m != LARGEST else pytest.param(m, marks=pytest.mark.soak) for m in MODELS])
@pytest.mark.parametrize("seed", ["0", pytest.param("4242", marks=pytest.mark.soak)])
def test_regenerating_gives_the_committed_bytes(model, seed, tmp_path):
    """Two hash seeds, each in a working folder of its own."""
    code = (
        "import json; from mehvar.codegen.generate import derive, installed_tree\n"
        f"print(json.dumps(derive(installed_tree(), {model!r}, whole=False)))"
    )
    texts = json.loads(python(code, tmp_path, PYTHONHASHSEED=seed))
    folder = ROOT / "generated" / model
    assert {p.name for p in folder.iterdir() if p.is_file()} == set(texts)
    for name, text in texts.items():
        assert (folder / name).read_text(encoding="utf-8") == text, f"{name}: run mehvar generate {model}"


ANSWERS = """
import json, sys
from mehvar.codegen.diff import compare
from mehvar.codegen.build import built_folder
from mehvar.models.parts import Bob, Hub, Spacecraft, Wheel
from tests.codegen.diff.pairs import pairs

craft = Spacecraft("craft")
craft.add(Hub("hub", mass=100.0, inertia=((12.0, 0.1, 0.2), (0.1, 14.0, 0.3), (0.2, 0.3, 10.0))))
for k, axis in enumerate([(1, 1, 1), (1, -1, 1), (-1, 1, 1)]):
    craft.add(Wheel(f"wheel{k}", axis=axis, inertia=0.1))
craft.add(Bob("tank", mass=20.0, length=0.3, at=(0.1, 0.2, 0.5), damping=0.1))
texts = {path.name: path.read_text() for path in built_folder(craft).iterdir() if path.is_file()}
answers = [[pair.name, repr(compare(pair.old, pair.new))] for pair in pairs()[:: int(sys.argv[1])]]
print(json.dumps([texts, answers]))
"""


def _under_seed(seed, every, folder):
    """Return generated texts and verdicts of a fresh process, with a cache of its own."""
    return json.loads(python(ANSWERS, folder, str(every), PYTHONHASHSEED=seed, MEHVAR_CACHE=str(folder / seed)))


@pytest.mark.soak
@pytest.mark.parametrize(("seed", "every"), [("2", 150), ("3", 37)])
def test_the_order_of_a_set_changes_no_text_and_no_verdict(seed, every, tmp_path):
    """An assembled craft and pairs of many classes: a set of names has another order under every hash seed."""
    texts, answers = _under_seed("1", every, tmp_path)
    assert len(texts) > 3
    assert len(answers) >= 4
    assert _under_seed(seed, every, tmp_path) == [texts, answers]


@pytest.mark.parametrize("model", MODELS)
def test_the_committed_files_are_fresh(model):
    assert check(installed_tree(), model).reasons == ()


def test_checking_needs_neither_sympy_nor_casadi(tmp_path):
    code = (
        "import sys; from mehvar.codegen.generate import check, generate, installed_tree\n"
        "check(installed_tree(), 'triangle'); generate(installed_tree(), 'triangle')\n"
        "print([m for m in ('sympy', 'casadi') if m in sys.modules])"
    )
    assert python(code, tmp_path).strip() == "[]"


def test_a_changed_source_is_named(tree):
    path = tree.root / "models" / "triangle" / "parameters.toml"
    path.write_text(path.read_text() + "\n# a remark\n")
    report = check(tree, "triangle")
    assert report.reasons == ("models/triangle/parameters.toml changed",)
    assert "triangle.c" in report.written


def test_an_edited_or_missing_file_is_named(tree):
    folder = tree.root / "generated" / "triangle"
    (folder / "triangle.c").write_text("/* mine */")
    (folder / "triangle.py").unlink()
    assert check(tree, "triangle").reasons == ("triangle.c was edited by hand", "triangle.py is missing")


@pytest.mark.parametrize("text", ["", "{", "[]", '{"schema": 1}'])
def test_a_damaged_manifest_is_mended(tree, text):
    (tree.root / "generated" / "triangle" / "manifest.json").write_text(text)
    assert "is damaged" in check(tree, "triangle").reasons[0]


@pytest.mark.parametrize("derived", [False, pytest.param(True, marks=pytest.mark.soak)])
def test_a_changed_number_changes_no_code(tree, derived):
    """Nor does deriving anew, which mends what was edited or lost."""
    path = tree.root / "models" / "triangle" / "parameters.toml"
    path.write_text(path.read_text().replace("default = 0.65", "default = 0.6"))
    before = {p.name: p.read_bytes() for p in (tree.root / "generated" / "triangle").iterdir()}
    code = (
        "import sys; from pathlib import Path\n"
        "from mehvar.codegen.generate import find_tree, generate\n"
        "generate(find_tree(Path.cwd()), 'triangle')\n"
        "print([m for m in ('sympy', 'casadi') if m in sys.modules])"
    )
    assert python(code, tree.root, PYTHONPATH=f"{tree.root}:{ROOT}").strip() == "[]"
    assert check(tree, "triangle").reasons == ()
    folder = tree.root / "generated" / "triangle"
    renumbered = {p.name: p.read_bytes() for p in folder.iterdir()}
    assert {name for name in before if before[name] != renumbered[name]} == {"manifest.json"}
    if not derived:
        return
    (folder / "manifest.json").unlink()
    (folder / "triangle.py").unlink()
    (folder / "triangle.c").write_text("/* mine */")
    generate_in(tree)
    assert {p.name: p.read_bytes() for p in folder.iterdir()} == renumbered, "deriving gives other files"


@pytest.mark.parametrize(
    ("table", "old", "new"),
    [
        ("parameters.toml", 'bounds = "(0, inf)"', 'bounds = "[0, inf)"'),
        ("parameters.toml", "default = 0.65", 'default = "2*R"'),
        ("scenarios.toml", 'kind = "max"', 'kind = "min"'),
    ],
)
def test_more_than_a_number_is_derived_again(tree, table, old, new):
    path = tree.root / "models" / "triangle" / table
    shape = shapes(path.parent)[table]
    assert old in path.read_text()
    path.write_text(path.read_text().replace(old, new, 1))
    assert shapes(path.parent)[table] != shape


@pytest.mark.parametrize(
    ("table", "old", "new", "message"),
    [
        ("parameters.toml", "default = 0.65", "default = -1.0", "default = -1 is outside its bounds"),
        ("scenarios.toml", "k_phi = 5.0", "k_phi = -5.0", "k_phi = -5 is outside its bounds"),
    ],
)
def test_a_number_out_of_bounds_is_refused_and_nothing_is_written(tree, table, old, new, message):
    path = tree.root / "models" / "triangle" / table
    assert old in path.read_text()
    path.write_text(path.read_text().replace(old, new, 1))
    manifest = tree.root / "generated" / "triangle" / "manifest.json"
    before = manifest.read_bytes()
    with pytest.raises(ModelError, match=message):
        generate(tree, "triangle")
    assert manifest.read_bytes() == before


def test_two_at_once_do_not_mix(tmp_path):
    """Two processes write different texts again and again; whoever looks under the lock sees one set."""
    code = (
        "import sys; from pathlib import Path; from mehvar.codegen.generate import write\n"
        "for k in range(40): write(Path('out'), {f'{n}.txt': sys.argv[1] + str(k) for n in range(20)})"
    )
    writers = [subprocess.Popen([sys.executable, "-c", code, who], cwd=tmp_path, env=ENVIRONMENT) for who in "ab"]
    looks = 0
    while any(writer.poll() is None for writer in writers):
        folder = tmp_path / "out"
        if folder.is_dir():
            with locked(folder):
                seen = {p.read_text() for p in folder.glob("*.txt")}
            assert len(seen) <= 1
            looks += bool(seen)
    assert looks
    assert [writer.returncode for writer in writers] == [0, 0]


def test_nothing_is_half_written(tree, monkeypatch):
    """A disk that fills up while writing leaves the old files whole and no scratch behind."""
    folder = tree.root / "generated" / "triangle"
    before = {p.name: p.read_bytes() for p in folder.iterdir()}
    texts = {name: content.decode() + "\n" for name, content in before.items()}
    plain = Path.write_text

    def full(self, text, **options):
        if self.name == "triangle.py":
            raise OSError(28, "No space left on device", str(self))
        return plain(self, text, **options)

    monkeypatch.setattr(Path, "write_text", full)
    with pytest.raises(OSError, match="No space left"):
        write(folder, texts)
    assert {p.name: p.read_bytes() for p in folder.iterdir()} == before


def test_what_is_committed_can_be_read():
    """As many lines as a reviewer may meet; what few read is made when it is asked for."""
    files = {path: path.read_bytes().count(b"\n") for path in (ROOT / "generated").rglob("*.*") if path.is_file()}
    files = {path: lines for path, lines in files.items() if path.suffix != ".pyc"}
    assert sum(files.values()) <= 70_000
    assert max(files.values()) <= 8_000
    assert not {path.name for path in files} & {name for model in MODELS for name in files_on_first_use(model)}
    attributes = ["git", "check-attr", "linguist-generated", "--", *map(str, files)]
    told = subprocess.run(attributes, cwd=ROOT, capture_output=True, text=True, check=True).stdout.splitlines()
    assert [line for line in told if not line.endswith(": set")] == [
        f"{ROOT}/generated/__init__.py: linguist-generated: unspecified"
    ]


@pytest.mark.soak
def test_a_variant_goes_where_it_is_told(tmp_path):
    generate(installed_tree(), "triangle", out=tmp_path / "mine", structure={"masses": "general"})
    manifest = read_manifest(tmp_path / "mine")
    left = files_on_first_use("triangle") - {path.name for path in (tmp_path / "mine").iterdir()}
    assert left == {"triangle_casadi.c", "triangle_casadi.h"}, "a folder elsewhere has all but what needs --emit"
    assert [p.name for p in manifest.parameters] == ["H", "disturbance", "m1", "m2", "m3"]
    assert manifest_text(manifest) == manifest.text
    assert not generate(installed_tree(), "triangle", out=tmp_path / "mine", structure={"masses": "general"}).stale


def test_casadis_own_c_is_written_on_request_and_kept_from_then_on(tree, monkeypatch):
    """The derivation of the installed tree stands for that of its copy, what is committed for the one without."""
    folder, (code, header) = tree.root / "generated" / "triangle", ("triangle_casadi.c", "triangle_casadi.h")
    committed = {path.name: path.read_text(encoding="utf-8") for path in folder.iterdir()}
    texts = {False: committed, True: derive(installed_tree(), "triangle", casadi=True, whole=False)}
    monkeypatch.setattr(generation, "derive", lambda tree, model, structure, casadi, whole: texts[casadi])
    (folder / "manifest.json").unlink()
    generate(tree, "triangle")
    assert not (folder / code).exists()
    generate(tree, "triangle", casadi=True)
    assert "int triangle_rhs(const casadi_real** arg" in (folder / code).read_text()
    assert "triangle_jac_x" in (folder / header).read_text()
    for name in (code, "manifest.json"):
        (folder / name).unlink()
        assert check(tree, "triangle").stale
        generate(tree, "triangle")
        assert (folder / code).is_file()
        assert not check(tree, "triangle").stale


@pytest.mark.parametrize(
    ("model", "structure", "message"),
    [
        ("triangel", {}, "model 'triangel' is not known"),
        ("triangle", {"mass": "equal"}, "triangle has no structure 'mass'; it has: masses"),
        ("triangle", {"masses": "odd"}, "structure masses = 'odd' is not one of equal, general"),
    ],
)
def test_unknown_names_are_refused(model, structure, message):
    with pytest.raises(GenerateError, match=message):
        derive(installed_tree(), model, structure)


def test_the_tree_is_found_from_inside(tree):
    assert find_tree(tree.root / "models" / "triangle") == tree
    assert find_tree(Path("/")) is None


def test_texts_hold_no_machine_path_and_no_date():
    for path in (ROOT / "generated").rglob("*"):
        if path.is_file() and path.suffix in (".c", ".h", ".py", ".json", ".md"):
            assert str(ROOT) not in path.read_text(encoding="utf-8")
