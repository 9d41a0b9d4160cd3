"""README and the pages under docs: every block runs, links lead somewhere. The pages that are generated are looked at by
test_reference.py as well."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import copies
import pytest
from _pytest.mark.structures import ParameterSet
from sampling import one_in

from scenelang import Evaluated, Options, Session, Source
from scenelang.grammar.diagnostics import render_text
from scenelang.interpreter.expand.forms import FORMS
from scenelang.interpreter.runtime.types import BASE_TYPES
from scenelang.stdlib import reference
from scenelang.stdlib.library import PRELUDE, build_library

ROOT = Path(__file__).parents[1]
# Pages whose examples are run where what they show is tested, or that have no examples.
TESTED_ELSEWHERE = {"cli", "diagnostics", "forms", "relations", "tolerances"}
DOCUMENTS = (
    "README.md",
    "docs/language.md",
    "docs/tutorial.md",
    "docs/pictures.md",
    "docs/figures.md",
    "docs/python.md",
    "docs/labels.md",
    "docs/datasets.md",
    "docs/minecraft.md",
    "docs/from-openscad.md",
    "docs/from-blender.md",
    "docs/from-trimesh.md",
    "docs/from-cadquery.md",
    "docs/from-threejs.md",
    "docs/from-paper-python.md",
    "docs/cookbook.md",
    *(f"docs/cookbook/{path.name}" for path in sorted((ROOT / "docs" / "cookbook").glob("*.md"))),
    "docs/splatting.md",
    "docs/imagine.md",
    "docs/grammar.md",
    "docs/editors.md",
    "docs/mcp.md",
    "docs/bench.md",
    "docs/language-models.md",
    "docs/embeddings.md",
    "docs/distillation.md",
    "docs/inversion.md",
    "docs/evaluation.md",
    "docs/reference/diagnostics.md",
    "docs/reference/cli.md",
    "docs/checker.md",
    "docs/repl.md",
    "docs/viewer.md",
    "docs/index.md",
    "docs/install.md",
    "docs/cheat-sheet.md",
    "docs/commands.md",
    "docs/transpiler.md",
    "docs/ten-minutes.md",
    "docs/concepts.md",
    "docs/paper.md",
    "docs/faq.md",
    *(
        f"docs/reference/{path.name}"
        for path in sorted((ROOT / "docs" / "reference").glob("*.md"))
        if path.stem not in TESTED_ELSEWHERE
    ),
    *(f"docs/tutorials/{path.name}" for path in sorted((ROOT / "docs" / "tutorials").glob("*.md"))),
)


def blocks(document: str, language: str) -> list[tuple[int, str]]:
    """The fenced blocks of a language, each with its line."""
    text = (ROOT / document).read_text("utf-8")
    text = re.sub(r"^````.*?^````$", lambda whole: "\n" * whole[0].count("\n"), text, flags=re.M | re.S)
    found = re.finditer(rf"^```{language}\n(.*?)^```$", text, re.M | re.S)
    return [(text.count("\n", 0, match.start()) + 2, match[1]) for match in found]


def block_parameters(language: str) -> list[ParameterSet]:
    return [
        pytest.param(text, id=f"{document}:{line}")
        for document in DOCUMENTS
        for line, text in blocks(document, language)
    ]


def evaluate(text: str) -> Evaluated:
    return Session(Options(project=ROOT)).evaluate(Source("<block>", text))


@pytest.mark.parametrize("text", block_parameters("scene"))
def test_scene_blocks_run(text: str) -> None:
    """A comment such as ``; W306`` says what is found there; nothing else may be."""
    checked = Session().check(Source("<block>", text))
    announced = re.findall(r"; ([EW]\d{3})\b", text)
    if announced:
        assert [d.code for d in checked.diagnostics] == announced
        return
    assert [render_text(d) for d in checked.diagnostics] == []
    assert checked.program is not None
    if checked.program.words:
        result = evaluate(text)
        assert [render_text(d) for d in result.diagnostics] == []
        assert result.scene is not None
        assert any(root.children for root in result.scene.frames)


WRONG = [
    pytest.param(codes.split(), text, id=f"{document}:{codes}")
    for document in DOCUMENTS
    if document != "docs/reference/diagnostics.md"  # whose programs need their own commands
    for codes, text in re.findall(
        r"^```scene wrong ([EW\d ]+)\n(.*?)^```$", (ROOT / document).read_text("utf-8"), re.M | re.S
    )
]


@pytest.mark.parametrize(("codes", "text"), WRONG)
def test_wrong_blocks_have_the_findings_they_claim(codes: list[str], text: str) -> None:
    assert [d.code for d in Session().check(Source("<block>", text)).diagnostics] == codes


@pytest.mark.parametrize("text", block_parameters("python"))
def test_python_blocks_run(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    if "out/" in text:
        (ROOT / "out").mkdir(exist_ok=True)
    names: dict[str, object] = {"__name__": "block"}
    exec(compile(text, "<block>", "exec"), names)
    assert "import scenelang" in text


def _named_blocks() -> Iterator[tuple[str, str]]:
    """The blocks of the cookbook that begin with the name of a file, in a comment."""
    for document in DOCUMENTS:
        if document.startswith("docs/cookbook/"):
            for _, block in [*blocks(document, "scene"), *blocks(document, "toml")]:
                name = re.match(r"[;#] (\w+\.(?:scene|toml))\n", block)
                if name:
                    yield name[1], block


SHELL = block_parameters("sh")
README = [each for each in SHELL if each.id is not None and each.id.startswith("README")]


@pytest.mark.parametrize("text", [*README, *one_in(3, [each for each in SHELL if each not in README])])
def test_shell_blocks_run(text: str, tmp_path: Path) -> None:
    """The commands of a block, one after the other in one folder, with the examples and named blocks at hand; `make` only by
    name."""
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    (tmp_path / "out").mkdir()
    scenes = blocks("README.md", "scene")
    (tmp_path / "pawns.scene").write_text(scenes[0][1], "utf-8")
    (tmp_path / "harbour.scene").write_text(blocks("docs/tutorial.md", "scene")[-1][1], "utf-8")
    for name, block in _named_blocks():
        (tmp_path / name).write_text(block, "utf-8")
    commands = [line.partition("  #")[0].strip() for line in text.splitlines() if line.strip()]
    assert commands
    for command in commands:
        if command.startswith("make "):
            makefile = ROOT / "Makefile"
            assert not makefile.exists() or re.search(rf"^{command[5:]}:", makefile.read_text("utf-8"), re.M)
            continue
        if command.startswith(("git ", "cd ", "pip ", "pipx ")):
            continue
        assert command.startswith("scenelang "), command
        if re.search(r"[|<>&;$`*]", command):  # for a shell
            ran = f'"{sys.executable}" -P -m scenelang {command.removeprefix("scenelang ")}'
            done = subprocess.run(ran, shell=True, cwd=tmp_path, capture_output=True, text=True)
        else:
            done = copies.command(*shlex.split(command)[1:], folder=tmp_path)
        assert done.returncode == 0, f"{command}\n{done.stderr}"


@pytest.mark.parametrize("document", DOCUMENTS)
def test_links_lead_somewhere(document: str) -> None:
    text = (ROOT / document).read_text("utf-8")
    anchors = _anchors(ROOT / document)
    targets = re.findall(r"\]\(([^)\s]+)\)", re.sub(r"^```.*?^```$", "", text, flags=re.M | re.S))
    targets += re.findall(r'src="([^"]+)"', text)
    assert targets
    for target in targets:
        if target.startswith("#"):
            assert target[1:] in anchors, target
        elif not target.startswith(("http", "live/")):
            path, _, part = target.partition("#")
            page = (ROOT / document).parent / path
            assert page.exists(), target
            if part:
                assert part in _anchors(page), target


def _anchors(page: Path) -> set[str]:
    titles = re.findall(r"^#+ (.*?)(?: \{#(\S+)\})?$", page.read_text("utf-8"), re.M)
    return {identifier or _anchor(title) for title, identifier in titles}


def _anchor(title: str) -> str:
    return re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-")


# --- the records of the reference ------------------------------------------------------------------------------------


def test_every_name_has_a_record() -> None:
    library = build_library()
    names = {record.name for record in reference.records()}
    assert set(FORMS) <= names
    assert set(library.builtins) <= names
    assert {name for builtins in library.imported.values() for name in builtins} <= names
    assert set(library.constants) <= names
    assert set(BASE_TYPES) <= names
    defined = {
        name for module in PRELUDE for name in re.findall(r"^\(define \(?([^\s()]+)", library.modules[module], re.M)
    }
    assert {name for name in defined if not name.startswith("%")} <= names


def test_names_are_documented_once_per_kind() -> None:
    seen = [(record.kind, record.name) for record in reference.records()]
    assert len(seen) == len(set(seen))
    for record in reference.records():
        assert record.doc.endswith((".", "`", "!")), record.name
        assert record.topic in reference.TOPICS
        assert record.name in record.signature


def test_lookup() -> None:
    ring = reference.lookup("ring")
    assert ring is not None
    assert ring.topic == "combinators"
    assert ring.signature.startswith("(ring count::Integer object::Template ")
    assert reference.lookup("no such name") is None


@pytest.mark.parametrize("topic", reference.TOPICS)
def test_reference_examples_give_what_they_say(topic: str) -> None:
    shown = [(r.name, e) for r in reference.records() if r.topic == topic for e in r.examples]
    if not shown:
        return
    body = "\n".join(f"(print (list '=> {example.expression}))" for _, example in shown)
    modules = {r.module for r in reference.records() if r.topic == topic and r.module is not None}
    imports = "".join(f'(import "{module}")\n' for module in modules)
    result = evaluate(f'{imports}{body}\n(bind "examples" (lambda () (call "cube")))')
    assert result.ok, [render_text(d) for d in result.diagnostics]
    printed = [line[4:-1] for line in result.log if line.startswith("(=> ")]
    assert printed == [example.value for _, example in shown], topic


def test_the_strict_program_of_the_page_about_the_paper_is_strict() -> None:
    (program,) = [text for _, text in blocks("docs/paper.md", "scene") if "::Embedding" in text]
    source = Source("paper.scene", program)
    assert [d for d in Session(Options(strict=True)).check(source).diagnostics if d.is_error] == []
