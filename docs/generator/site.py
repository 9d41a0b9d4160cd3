"""Hook of MkDocs: what the site has that the pages in the repository do not, and links that lead out of docs.

- Links to the repository's other pages become pages of the site; other files are copied below ``files``.
- The gallery shows the source of each example beside its picture.
- Each ``live/NAME.html`` is an example in the viewer, as one page that works offline.
- ``playground/`` is what `make playground` built, if it was run; each program then has a button that opens it in place.
"""

from __future__ import annotations

import contextlib
import logging
import posixpath
import re
import shutil
import sys
from pathlib import Path
from typing import Any

from mkdocs.structure.files import File, Files

DOCS = Path(__file__).parents[1]
ROOT = DOCS.parent
PAGES = {
    "CODE_OF_CONDUCT.md": "conduct.md", "CONTRIBUTING.md": "contributing.md",
    "CHANGELOG.md": "changelog.md", "SECURITY.md": "reporting.md",
}  # fmt: skip
LIVE = ("chessboard", "orrery")
PLAYGROUND = ROOT / ".playground"

# Pages about the project itself come after those about the product, and long lists of words are no answers.
_LAST = (
    "architecture.md", "decisions.md", "performance.md", "reference/index.md", "reference/tolerances.md",
    *PAGES.values(),
)  # fmt: skip

_LINK = re.compile(r"(?P<before>\]\()(?P<path>[^)\s#]+)(?P<anchor>#[^)\s]*)?\)")
_FENCE = re.compile(r"(^(?P<fence>`{3,}).*?^(?P=fence)$)", re.M | re.S)
_INFO = re.compile(r"^(`{3,}\w+)\b(?! title=)[^\n]*")  # words that only the tests of the documentation read
log = logging.getLogger("mkdocs.plugins.site")


def on_config(config: Any) -> Any:
    if (PLAYGROUND / "index.html").is_file():
        config.extra_javascript.append("assets/playground.js")
    return config


def on_files(files: Files, *, config: Any) -> Files:
    for source, page in PAGES.items():
        files.append(File.generated(config, page, content=(ROOT / source).read_text("utf-8")))
    linked = {path for file in files.documentation_pages() for path in _outside(file)}
    for path in sorted(linked - {ROOT / name for name in (*PAGES, "README.md")}):
        if path.is_file():
            name = path.relative_to(ROOT).as_posix()
            files.append(File.generated(config, f"files/{name}", content=path.read_bytes()))
    return files


def _outside(file: File) -> set[Path]:
    """The files of the repository that a page in docs links to, and that are outside docs."""
    links = _LINK.finditer(_FENCE.sub("", file.content_string))
    found = {(_folder(file) / link["path"]).resolve() for link in links if "://" not in link["path"]}
    return {path for path in found if ROOT in path.parents and DOCS not in path.parents}


def _folder(file: File) -> Path:
    """The folder that the links of a page start from in the repository."""
    return ROOT if file.src_uri in PAGES.values() else (DOCS / file.src_uri).parent


def _boost(name: str) -> float:
    """Return how much a page weighs in the search: names of the language most, lists of links little."""
    if name in _LAST:
        return 0.1
    if name in ("cookbook.md", "cheat-sheet.md", "gallery.md"):
        return 0.5
    return (
        2.0 if name.startswith("reference/") and name not in ("reference/diagnostics.md", "reference/cli.md") else 1.0
    )


def on_page_content(html: str, *, page: Any, **_: Any) -> str:
    """Mark each program, and say where the playground is, for the script of the site."""
    up = posixpath.relpath("playground/", posixpath.dirname(page.file.url) or ".")
    return f'<div class="page-programs" data-playground="{up}/" hidden></div>{html}'


def on_page_markdown(markdown: str, *, page: Any, **_: Any) -> str:
    page.meta.setdefault("search", {"boost": _boost(page.file.src_uri)})
    if page.file.src_uri == "gallery.md":
        markdown = _gallery()
    parts = _FENCE.split(markdown)
    texts, fences = parts[::3], parts[1::3]  # the second group repeats the fence's sign
    fences = [_INFO.sub(r"\1", fence) for fence in fences]
    return "".join(_with_links(text, page.file) + fence for text, fence in zip(texts, [*fences, ""], strict=True))


def _with_links(text: str, file: File) -> str:
    folder, here = _folder(file), posixpath.dirname(file.src_uri)

    def changed(link: re.Match[str]) -> str:
        if "://" in link["path"]:
            return link[0]
        path = (folder / link["path"]).resolve()
        if ROOT not in path.parents:
            return link[0]
        name, anchor = path.relative_to(ROOT).as_posix(), link["anchor"] or ""
        if name == "README.md":
            target, anchor = "index.md", ""
        elif path == ROOT / "examples":
            target = "gallery.md"
        elif DOCS in path.parents:
            target = path.relative_to(DOCS).as_posix()
        else:
            target = PAGES.get(name, f"files/{name}")
        return f"{link['before']}{posixpath.relpath(target, here or '.')}{anchor})"

    return _LINK.sub(changed, text)


def _gallery() -> str:
    """Return the gallery: all images as a grid, then each with its source."""
    sys.path.insert(0, str(DOCS))
    from gallery import SHOWN, title

    from generator.markdown import anchor

    titles = {name: title(example) for name, (example, _, _) in SHOWN.items()}
    grid = " ".join(f"[![{titles[name]}](gallery/{name}.jpg)](#{anchor(titles[name])})" for name in SHOWN)
    parts = [
        "# Gallery\n",
        "Every example, path traced; a click leads to its program. `scenelang view FILE` shows one in a browser.\n",
        f'<div class="strip" markdown>\n\n{grid}\n\n</div>\n',
    ]
    for name, (example, _, _) in SHOWN.items():
        path = ROOT / "examples" / f"{example}.scene"
        parts.append(
            f'## {titles[name]}\n\n<div class="example" markdown>\n\n![{titles[name]}](gallery/{name}.jpg)\n\n'
            f'```scene title="examples/{example}.scene"\n{path.read_text("utf-8")}```\n\n</div>\n'
        )
    return "\n".join(parts)


def on_post_build(*, config: Any) -> None:
    from scenelang.cli.main import main

    if (PLAYGROUND / "index.html").is_file():
        shutil.copytree(PLAYGROUND, Path(config.site_dir, "playground"), dirs_exist_ok=True)
    folder = Path(config.site_dir, "live")
    folder.mkdir(parents=True, exist_ok=True)
    with contextlib.chdir(ROOT):  # the page shows the path of its program
        for name in LIVE:
            if main(["view", f"examples/{name}.scene", "--html", str(folder / f"{name}.html"), "-q"]):
                log.warning("the viewer's page of %s was not written", name)
