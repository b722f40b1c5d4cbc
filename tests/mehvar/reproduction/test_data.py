# SPDX-License-Identifier: Apache-2.0
import shutil
from pathlib import Path

import pytest

from mehvar.base.errors import InputError
from mehvar.base.schema import read_data
from mehvar.reproduction.claims import ClaimText
from mehvar.reproduction.paper import Captions, read_reproduction
from mehvar.reproduction.study import Study
from papers import triangle
from papers.triangle.claims import CHECKS
from tests.derived import REPRODUCED

DATA = Path(triangle.__file__).parent


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('title = "What ρ', 'titel = "What ρ', r"captions.toml: figure\[1\].titel is not known \(did you mean 'title'"),
        ("number = 3", 'number = "three"', r"captions.toml: figure\[2\].number = 'three': must be a whole number"),
        ("[scene]", "[stage]", r"captions.toml: stage is not known; known: citation, "),
        ("number = 4", "number = 44", r"captions.toml: figures \[1, 2, 3, 44"),
        ('citation = """', "citation = ", r"captions.toml is not TOML: .*line"),
    ],
)
def test_a_wrong_caption_is_told_with_its_file_and_field(tmp_path, old, new, message):
    folder = shutil.copytree(DATA, tmp_path / "triangle")
    captions = folder / "captions.toml"
    text = captions.read_text(encoding="utf-8")
    assert old in text
    captions.write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(InputError, match=message):
        read_reproduction(folder, draw=dict.fromkeys(range(1, 12)), checks=CHECKS, picture=None)


def test_claims_without_checks_and_numbers_without_a_name_are_told(tmp_path):
    folder = shutil.copytree(DATA, tmp_path / "triangle")
    with pytest.raises(
        InputError, match=r"claims.toml: claims \['1', .* do not match the functions of the code, \['1'\]"
    ):
        read_reproduction(folder, draw=dict.fromkeys(range(1, 12)), checks={"1": None}, picture=None)
    with pytest.raises(InputError, match=r"claim 2 \(claims.toml\) lacks the expected number 'time'"):
        ClaimText("2", "text").number_of("time")


def test_every_paper_has_its_files_and_nothing_else_of_data():
    for name in REPRODUCED:
        folder = DATA.parent / name
        assert {"captions.toml", "claims.toml", "study.toml"} <= {path.name for path in folder.iterdir()}
        assert read_data(folder / "captions.toml", Captions).readings
        assert read_data(folder / "study.toml", Study).runs > 500


def test_a_missing_file_is_told(tmp_path):
    with pytest.raises(InputError, match=r"cannot read .*study.toml: No such file"):
        read_data(tmp_path / "study.toml", Study)
