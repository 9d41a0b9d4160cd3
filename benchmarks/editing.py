"""Edits: the new scene after a change of a text, new findings, and what an editor waits for at a key."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from itertools import count
from pathlib import Path
from typing import Any

from measuring import Goal, Pair, Row, Timed, timed

HOUSES = 70  # seven lines each, 500 lines in all


def town(size: object = 1, step: object = 3, head: str = "") -> str:
    """A scene of 70 words; ``size`` is of one of them, ``step`` of a helper that all use, ``head`` stands above."""
    houses = [
        f"(define (offset{i} k)\n  [(spread k) {i} (sin (* k {i}))])\n"
        f'(bind "house{i}"\n  (lambda ()\n    (for*/union ((k (range 60)) (j (range 8)))\n'
        f'      (transform (call "cube" :scale [{size if i == 7 else 1} 1 (+ 1 (* .1 j))])\n'
        f"        (translate (+ (offset{i} k) [0 j 0]))))))\n"
        for i in range(HOUSES)
    ]
    calls = "".join(f'\n    (transform (call "house{i}") (translate [0 0 {10 * i}]))' for i in range(HOUSES))
    helper = f"(define (spread k) (* {step} k))\n"
    return f'{head}{helper}{"".join(houses)}(bind "town"\n  (lambda () (union{calls})))\n(scene "town")\n'


def sheds(lines: int, number: object = 0) -> str:
    """A program of so many lines, of which ``number`` is written in the middle."""
    forms = [
        f'(define (f{i} x)\n  (* x {i}))\n(bind "w{i}"\n  (lambda ()\n    (call "cube" :scale (f{i} 1))))\n'
        for i in range(lines // 5)
    ]
    return "".join([*forms[: len(forms) // 2], f"(define (g x) {number})\n", *forms[len(forms) // 2 :]])


EDITS: dict[str, Callable[[int], str]] = {
    "a comment": lambda i: town(head=f"; number {i}\n"),
    "a blank line": lambda i: town(head="\n" * (i % 2)),
    "a helper that all use": lambda i: town(step=3 + i),
    "one word": lambda i: town(size=1 + i),
    "an unused definition": lambda i: town(head=f"(define unused {i})\n"),
}


def edited(edit: str) -> list[Pair]:
    """The new scene from the arrival of the changed text, beside the evaluation of that text from scratch."""
    from scenelang.grammar.datum import Source
    from scenelang.session.editing import Editing
    from scenelang.session.session import Session

    session, numbers = Session(), count(1)
    editing = Editing(session)
    editing.evaluate(Source("town.scene", EDITS[edit](0)))

    def changed() -> Source:
        return Source("town.scene", EDITS[edit](next(numbers)))

    return [Pair(Timed(editing.evaluate, changed), Timed(session.evaluate, changed))]


def checked(lines: int) -> list[Pair]:
    """The findings after a change, beside those of the whole text."""
    from scenelang.grammar.datum import Source
    from scenelang.session.editing import Editing
    from scenelang.session.session import Session

    session, numbers = Session(), count(1)
    editing = Editing(session)
    editing.check(Source("sheds.scene", sheds(lines)))

    def changed() -> Source:
        return Source("sheds.scene", sheds(lines, next(numbers)))

    return [Pair(Timed(editing.check, changed), Timed(session.check, changed))]


@contextmanager
def watched_file() -> Iterator[Callable[[], Path]]:
    """Yield what writes the town with another size of a word into a file, and returns its path."""
    numbers = count(1)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "town.scene"

        def change() -> Path:
            path.write_text(town(size=next(numbers)), "utf-8")
            return path

        yield change


def watched(use: Callable[[Any, Path], Callable[[Path], Any]]) -> Iterator[Pair]:
    """An edit of a word, written to a file, beside its evaluation from scratch; ``use`` says who reads the file."""
    from scenelang.session.session import Session

    session = Session()
    with watched_file() as change:
        reload = use(session, change())
        yield Pair(Timed(reload, change), Timed(lambda path: session.evaluate(session.source(str(path))), change))


def in_repl(session: Any, path: Path) -> Callable[[Path], Any]:
    from scenelang.repl.evaluation import ReplEvaluation

    evaluation = ReplEvaluation(session, str(path))

    def reload(path: Path) -> Any:
        evaluation.reload(str(path))
        return evaluation.root()

    reload(path)
    return reload


def in_view(session: Any, path: Path) -> Callable[[Path], Any]:
    from scenelang.viewer import workspace

    view = workspace.evaluator(lambda _, __: session, session.options.limits.primitives)
    view(str(path), {})
    return lambda path: view(str(path), {})


def bound_in_repl() -> Iterator[Pair]:
    """A word that is bound in the REPL, and the scene with it."""
    from scenelang.repl.evaluation import ReplEvaluation
    from scenelang.session.session import Session

    session, numbers = Session(), count(1)
    with watched_file() as change:
        path = str(change())
        evaluation = ReplEvaluation(session, path)
        evaluation.reload(path)
        evaluation.root()

        def bind() -> Any:
            evaluation.evaluate(evaluation.source(f'(bind "house3" (lambda () (call "w{next(numbers)}")))'))
            return evaluation.root()

        yield Pair(timed(bind), timed(lambda: session.evaluate(session.source(path))))


# --- the language server ------------------------------------------------------------------------------------------


class Editor:
    """An editor that speaks the protocol with the language server over pipes."""

    def __init__(self, text: str) -> None:
        words = [sys.executable, "-m", "scenelang", "lsp"]
        self.process = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        self.numbers, self.uri = count(1), "file:///tmp/sheds.scene"
        self.ask("initialize", {"processId": None, "rootUri": None, "capabilities": {}})
        self.tell("initialized", {})
        self.tell(
            "textDocument/didOpen",
            {"textDocument": {"uri": self.uri, "languageId": "scene", "version": 1, "text": text}},
        )

    def tell(self, method: str, params: Any, number: int | None = None) -> None:
        message = {"jsonrpc": "2.0", "method": method, "params": params} | ({} if number is None else {"id": number})
        data = json.dumps(message).encode()
        assert self.process.stdin is not None
        self.process.stdin.write(b"Content-Length: %d\r\n\r\n%s" % (len(data), data))
        self.process.stdin.flush()

    def ask(self, method: str, params: Any) -> Any:
        """Send a request, and return its result, what comes between being ignored."""
        number = next(self.numbers)
        self.tell(method, params, number)
        while (message := self.read()).get("id") != number:
            pass
        return message["result"]

    def read(self) -> dict[str, Any]:
        assert self.process.stdout is not None
        length = 0
        while (line := self.process.stdout.readline().strip()) or not length:
            if not line and self.process.poll() is not None:
                raise RuntimeError("the language server ended")
            if line.lower().startswith(b"content-length:"):
                length = int(line.split(b":")[1])
        message: dict[str, Any] = json.loads(self.process.stdout.read(length))
        return message

    def type_key(self, line: int, version: int) -> float:
        """Seconds, by the clock, from a key to its completions and to the colours of the lines that are seen."""
        place = {"line": line, "character": 14}
        change = {"range": {"start": place, "end": place}, "text": str(version % 10)}
        document = {"uri": self.uri}
        started = time.perf_counter()
        self.tell(
            "textDocument/didChange",
            {"textDocument": {**document, "version": version}, "contentChanges": [change]},
        )
        self.ask("textDocument/completion", {"textDocument": document, "position": place})
        seen = {"start": {"line": max(0, line - 20), "character": 0}, "end": {"line": line + 20, "character": 0}}
        self.ask("textDocument/semanticTokens/range", {"textDocument": document, "range": seen})
        return time.perf_counter() - started


def typed(lines: int) -> Iterator[Pair]:
    """A key in the middle of a program, in the language server; by the clock, since the editor waits."""
    text, versions = sheds(lines, 1), count(2)
    line = text[: text.index("(define (g x)")].count("\n")
    editor = Editor(text)
    for _ in range(3):
        editor.type_key(line, next(versions))

    def key() -> float:
        time.sleep(0.1)  # the findings, which come a moment later, are out
        return editor.type_key(line, next(versions))

    yield Pair(key)
    editor.process.kill()
    editor.process.wait()


ROWS = (
    Row("edit of a comment, 500 lines", partial(edited, "a comment"), "from scratch", (Goal(0.005, "ours"),), rounds=3),
    Row(
        "edit of a blank line, 500 lines", partial(edited, "a blank line"), "from scratch",
        (Goal(0.005, "ours"),), rounds=3,
    ),
    Row(
        "edit of a helper that all use, 500 lines", partial(edited, "a helper that all use"), "from scratch",
        (Goal(0.3, "ours"),), rounds=3,
    ),
    Row("edit of one word, 500 lines", partial(edited, "one word"), "from scratch", (Goal(0.05, "ours"),), rounds=3),
    Row(
        "edit of an unused definition, 500 lines", partial(edited, "an unused definition"), "from scratch",
        (Goal(0.05, "ours"),), rounds=3,
    ),
    Row("edit of one word, `,watch`", partial(watched, in_repl), "from scratch", (Goal(0.05, "ours"),), rounds=3),
    Row("edit of one word, `view`, its picture", partial(watched, in_view), "from scratch", rounds=3),
    Row("a word bound in the REPL", bound_in_repl, "from scratch", (Goal(0.05, "ours"),), rounds=3),
    Row("check after an edit, 3,000 lines", partial(checked, 3_000), "from scratch", (Goal(0.1),)),
    Row("key in the language server, 500 lines", partial(typed, 500), goals=(Goal(0.02, "ours"),), rounds=20),
    Row("key in the language server, 3,000 lines", partial(typed, 3_000), goals=(Goal(0.05, "ours"),), rounds=20),
)  # fmt: skip
