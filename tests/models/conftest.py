"""A place for commands that ask a model: folders of their own, a key that must not be seen, a server that answers."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from models.server import ModelServer, Said, Script, serving
from models.services import trust_nobody
from scenelang.cli.main import main
from scenelang.inference import conductor
from scenelang.inference import steps as answer_pictures

KEY = "sk-ant-planted-0123456789-KEY"
RESPONSES = Path(__file__).parents[1] / "transpile" / "responses"
GOLDEN = Path(__file__).parents[1] / "transpile" / "golden"
FOREIGN = (
    "SCENELANG_RUNS", "SCENELANG_TRACEBACK", "ANTHROPIC_LOG", "ANTHROPIC_AUTH_TOKEN", "ANTHROPIC_CUSTOM_HEADERS",
    "OPENAI_API_KEY", "OPENAI_BASE_URL", "OPENAI_LOG",
    "http_proxy", "https_proxy", "all_proxy", "HTTP_PROXY", "HTTPS_PROXY", "ALL_PROXY",
)  # fmt: skip


def recorded(name: str) -> str:
    """A response of the corpus."""
    return (RESPONSES / f"{name}.txt").read_text("utf-8")


@dataclass
class Done:
    """What a command came to."""

    code: int
    out: str
    err: str


class Place:
    """Runs commands in process, in a folder of their own."""

    def __init__(
        self, folder: Path, capsys: pytest.CaptureFixture[str], serve: Callable[[Script], ModelServer]
    ) -> None:
        self.folder = folder
        self.work = folder / "work"
        self.runs = folder / "state" / "scenelang" / "runs"
        self.serve = serve
        self._capsys = capsys

    def run(self, *words: str) -> Done:
        self._capsys.readouterr()
        try:
            code = main(list(words))
        except SystemExit as end:
            code = int(end.code or 0)
        captured = self._capsys.readouterr()
        for word in ("Traceback", "internal error"):
            assert word not in captured.err, captured.err
        return Done(code, captured.out, captured.err)

    def generate(self, *words: str) -> Done:
        """A command that must succeed."""
        done = self.run("generate", *words)
        assert done.code == 0, done.err
        return done

    def run_folder(self) -> Path:
        """The folder of the only run."""
        (found,) = self.runs.iterdir()
        return found

    def differs(self, a: Path, b: Path) -> bool:
        """Whether two scenes differ, as `diff` sees it."""
        code = self.run("diff", str(a), str(b), "-q").code
        assert code in (0, 1)
        return code == 1


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Iterator[Place]:
    for name in ("work", "state", "cache", "config"):
        (tmp_path / name).mkdir()
    for name in FOREIGN:
        monkeypatch.delenv(name, raising=False)
    for name in ("STATE", "CACHE", "CONFIG"):
        monkeypatch.setenv(f"XDG_{name}_HOME", str(tmp_path / name.lower()))
    monkeypatch.setenv("ANTHROPIC_API_KEY", KEY)
    monkeypatch.setenv("ANTHROPIC_BASE_URL", "http://127.0.0.1:9")
    trust_nobody(monkeypatch, tmp_path / "config")
    monkeypatch.setattr(conductor, "_FIRST_WAIT", 0.02)  # for a batch
    monkeypatch.chdir(tmp_path / "work")
    with ExitStack() as servers:
        running: list[ModelServer] = []

        def serve(script: Script) -> ModelServer:
            """The one server of a test, which answers from a script; its address stays."""
            if running:
                running[0].renew(script)
            else:
                running.append(servers.enter_context(serving(script)))
                monkeypatch.setenv("ANTHROPIC_BASE_URL", running[0].url)
            return running[0]

        yield Place(tmp_path, capsys, serve)


@pytest.fixture
def untried(monkeypatch: pytest.MonkeyPatch) -> None:
    """Answers that do no harm are evaluated here without a trial in a copy of this process, which is large."""
    monkeypatch.setattr(answer_pictures, "trial", lambda work: None)


@pytest.fixture
def small_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures for the model that are quickly drawn."""
    draw = answer_pictures.picture
    monkeypatch.setattr(
        answer_pictures, "picture", lambda scene, view, frame=None, size=48: draw(scene, view, frame, 48)
    )
    monkeypatch.setattr(answer_pictures, "_VIEW_PX", 48)


# --- what was sent -------------------------------------------------------------------------------------------------


def texts(turn: dict[str, Any]) -> str:
    """The texts of a message of a request."""
    content = turn["content"]
    return content if isinstance(content, str) else "\n".join(p["text"] for p in content if p["type"] == "text")


def pictures(turn: dict[str, Any]) -> list[dict[str, Any]]:
    """The pictures of a message of a request."""
    return [part["source"] for part in turn["content"] if part["type"] == "image"]


def system(request: dict[str, Any]) -> str:
    return "\n".join(part["text"] for part in request["system"])


# --- small answers -------------------------------------------------------------------------------------------------


def python(body: str) -> str:
    """An answer with Python in it."""
    return f'```python\nfrom helper import *\n\n"""\na test\n"""\n\n\n{body.strip()}\n```\n'


def cubes(count: int = 1, height: float = 0.5, word: str = "pile") -> str:
    """An answer whose scene is a row of cubes that stand on y = 0; a greater ``height`` lets them float."""
    return python(f"""
@register()
def {word}() -> Shape:
    cube = primitive_call("cube", shape_kwargs={{"scale": (1, 1, 1)}}, color=(0.8, 0.1, 0.1))
    return loop({count}, lambda i: transform_shape(cube, translation_matrix((2 * i, {height}, 0))))
""")


WRONG = python("""
@register()
def pile() -> Shape:
    return library_call("pillar", height=2)
""")


def answers(*texts_: str) -> list[Said]:
    return [Said(text) for text in texts_]
