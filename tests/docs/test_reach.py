# SPDX-License-Identifier: Apache-2.0
"""A site of one page with everything that pages have: nothing of it is out of reach of keyboard or screen reader."""

import os

import pytest

from mehvar.runtime.model import catalogue
from tests.docs.test_site import ROOT
from tests.mehvar.browser import chromium, prefer
from tests.mehvar.pages import resize, violations

WIDE = "word " * 60
PAGE = f"""# Page

## Start

A [link](#start), `code`, and $`x^2`$:

```math
x = \\frac{{a}}{{b}}
```

```console
$ mehvar list  # {WIDE}
{WIDE}
```

```python
for k in range(10): print(f"{{k}} {WIDE}", 1.0, None, "text")  # remark
```

```bash
name=1; echo "$name" {WIDE}
```

```toml
value = {{ unit = "m", default = 1.5 }}
```

| | {" | ".join(f"column {k}" for k in range(30))} |
|{"---|" * 31}
| row | {" | ".join("1 000" for _ in range(30))} |
"""


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    config = pytest.importorskip("mkdocs.config")
    from mkdocs.commands.build import build

    place = tmp_path_factory.mktemp("site")
    docs, out = place / "docs", place / "out"
    docs.mkdir()
    (docs / "site").symlink_to(ROOT / "docs" / "site")
    for name in ("index", "other", "another"):
        (docs / f"{name}.md").write_text(PAGE, encoding="utf-8")
    nav = [{"Start": ["index.md", "other.md"]}, {"Others": ["another.md"]}]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(catalogue, "shipped_models", dict)  # without pages that run
        patch.setitem(os.environ, "NO_MKDOCS_2_WARNING", "1")
        with (ROOT / "mkdocs.yml").open("rb") as file:
            build(config.load_config(file, docs_dir=str(docs), site_dir=str(out), nav=nav, plugins=["search"]))
    return out


@pytest.mark.parametrize(
    ("name", "width", "color"), [("index", 1440, "light"), ("index", 390, "dark"), ("404", 390, "dark")]
)
def test_axe_finds_nothing(site, browser, name, width, color):
    resize(browser, width)
    prefer(browser, prefers_color_scheme=color)
    browser.get((site / f"{name}.html").as_uri())
    assert violations(browser) == []


@pytest.fixture(scope="module")
def browser():
    with chromium() as driver:
        yield driver
