# SPDX-License-Identifier: Apache-2.0
"""mkdocs hooks that build a site from pages written for GitHub.

Four things differ. Pages link to files of the repository outside `docs/`: these become pages under `repo/`. Formulas
are TeX in the notation of forges: they become MathML, so that no script draws them. Reference pages name objects in
a comment, `<!-- ::: mehvar.load mehvar.batch -->`, which become directives of mkdocstrings. And every model has a page
on which it runs, `live/MODEL.html`.
"""

from __future__ import annotations

import posixpath
import re
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from mehvar.codegen.equations.mathml import content
from mehvar.reproduction.paper import load_reproduction
from mehvar.runtime.model.catalogue import shipped_models
from mehvar.web.export import export_web

if TYPE_CHECKING:
    from mkdocs.config.defaults import MkDocsConfig
    from mkdocs.structure.files import File, Files
    from mkdocs.structure.pages import Page

ROOT = Path(__file__).parents[2]
FENCED = re.compile(r"^(`{3,})(\w*)[^\n]*\n(.*?)^\1[ ]*$\n?", re.DOTALL | re.MULTILINE)
LINK = re.compile(r"(\]\()([^)\s:#]+)((?:#[^)\s]*)?\))")
INLINE = re.compile(r"\$`([^`\n]+)`\$")
OBJECTS = re.compile(r"^<!-- ::: ([^>]+) -->$", re.MULTILINE)
MARK = "\ue000{}\ue001"
"""Placeholder for a formula while Markdown converts the page."""

_LANGUAGES = {".py": "python", ".toml": "toml", ".c": "c", ".h": "c"}
_PICTURES = (".png", ".svg")
_SOURCE_BOOST = 0.1
"""Weight of source files in the search: words are about ten times as frequent in code as on pages."""
_formulas: dict[str, list[str]] = {}


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add every file of the repository that a page links to."""
    from mkdocs.structure.files import File

    waiting = [Path(config.docs_dir) / file.src_uri for file in files.documentation_pages()]
    seen = set(waiting)
    while waiting:
        for target in _targets(waiting.pop()) - seen:
            seen.add(target)
            if not target.is_relative_to(config.docs_dir):
                files.append(_file(target, config))
                waiting += [target] if target.suffix == ".md" else []
    for model in shipped_models():
        files.append(_live(model, config))
    fonts = ROOT / "mehvar" / "templates" / "fonts"
    for font in fonts.iterdir():
        files.append(File.generated(config, f"site/{font.name}", abs_src_path=str(font)))
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Convert links, replace formulas by placeholders, and insert the objects of reference pages."""
    own = page.file.src_uri
    if own.startswith("repo/"):
        page.meta.setdefault("search", {"boost": _SOURCE_BOOST})
    place = ROOT / own.removeprefix("repo/") if own.startswith("repo/") else Path(config.docs_dir) / own
    formulas = _formulas[own] = []

    def lead(match: re.Match[str]) -> str:
        target = (place.parent / match[2]).resolve()
        inside = posixpath.relpath(_home(target), posixpath.dirname(own) or ".") if target.is_file() else match[2]
        return f"{match[1]}{inside}{match[3]}"

    def set_aside(tex: str, display: str) -> str:
        formulas.append(f'<math display="{display}">{content(tex)}</math>')
        return MARK.format(len(formulas) - 1)

    def prose(text: str) -> str:
        text = INLINE.sub(lambda match: set_aside(match[1], "inline"), text)
        text = text.replace("<details>", '<details markdown="1">')
        return OBJECTS.sub(_directives, LINK.sub(lead, text))

    def fenced(match: re.Match[str]) -> str:
        return f"{set_aside(match[3], 'block')}\n" if match[2] == "math" else match[0]

    return "".join(_pieces(markdown, prose, fenced))


def on_page_content(html: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Insert the formulas; mark tables without column names as galleries."""
    formulas = _formulas.pop(page.file.src_uri)
    html = re.sub(r"<table>(?=\s*<thead>\s*<tr>\s*(?:<th[^>]*></th>\s*)+</tr>)", '<table class="gallery">', html)
    html = re.sub(r"<p>(\ue000\d+\ue001)</p>", r'<div class="formula" tabindex="0">\1</div>', html)
    return re.sub(r"\ue000(\d+)\ue001", lambda match: formulas[int(match[1])], html)


def on_post_page(output: str, page: Page, config: MkDocsConfig) -> str:
    """Name search and parts of the navigation for screen readers, and let wide code be scrolled with the keyboard."""
    output = re.sub(r'(<div class="md-search"[^>]* role="dialog")', r'\1 aria-label="Search"', output)
    output = re.sub(r'aria-labelledby="(__nav_\w+)_label"', r'aria-labelledby="\1_title"', output)
    output = re.sub(r'<label class="md-nav__title" for="(__nav_\w+)"', r'\g<0> id="\1_title"', output)
    output = re.sub(r"<th(?: [^>]*)?></th>", "<td></td>", output)
    return re.sub(r"(<pre[^>]*>(?:<span></span>)?<code)>", r'\1 tabindex="0">', output)


def _directives(match: re.Match[str]) -> str:
    return "\n\n".join(f"::: {name}" for name in match[1].split())


def _pieces(text: str, prose: Callable[[str], str], fenced: Callable[[re.Match[str]], str]) -> Iterator[str]:
    """Apply one function to the text between fenced blocks, another to the blocks."""
    end = 0
    for match in FENCED.finditer(text):
        yield prose(text[end : match.start()])
        yield fenced(match)
        end = match.end()
    yield prose(text[end:])


def _targets(place: Path) -> set[Path]:
    """Return the files that a page links to."""
    text = FENCED.sub("", place.read_text(encoding="utf-8"))
    places = {(place.parent / match[2]).resolve() for match in LINK.finditer(re.sub(r"`[^`\n]*`", "", text))}
    return {target for target in places if target.is_file() and target.is_relative_to(ROOT)}


def _home(target: Path) -> str:
    """Return the place of a file of the repository in the site."""
    path = target.relative_to(ROOT).as_posix()
    if path.startswith("docs/"):
        return path.removeprefix("docs/")
    return f"repo/{path}" if target.suffix in (".md", *_PICTURES) else f"repo/{path}.md"


def _file(target: Path, config: MkDocsConfig) -> File:
    """Return a file outside docs/ as a file of the site."""
    from mkdocs.structure.files import File

    if target.suffix in _PICTURES:
        return File.generated(config, _home(target), abs_src_path=str(target))
    return File.generated(config, _home(target), content=_as_page(target))


def _live(model: str, config: MkDocsConfig) -> File:
    """Return the page on which a model runs."""
    from mkdocs.structure.files import File

    study = load_reproduction(model).study
    with tempfile.TemporaryDirectory() as folder:
        page = export_web(model, folder, success=study.success, own_law=study.own_law.strip())
        text = page.read_text(encoding="utf-8")
    return File.generated(config, f"live/{model}.html", content=text)


def _as_page(target: Path) -> str:
    """Return a file as Markdown."""
    text = target.read_text(encoding="utf-8")
    if target.suffix == ".md":
        return text
    return f"# {target.relative_to(ROOT).as_posix()}\n\n````{_LANGUAGES.get(target.suffix, 'text')}\n{text}````\n"
