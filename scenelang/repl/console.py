"""REPL in a terminal: multi-line editing, history, highlighting, bracket matching and completion."""

from __future__ import annotations

import asyncio
import os
import re
import signal
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import redirect_stderr, redirect_stdout, suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from prompt_toolkit import PromptSession
from prompt_toolkit.application import Application, get_app, run_in_terminal
from prompt_toolkit.completion import CompleteEvent, Completer, Completion, PathCompleter
from prompt_toolkit.document import Document
from prompt_toolkit.filters import Condition
from prompt_toolkit.formatted_text import StyleAndTextTuples
from prompt_toolkit.formatted_text.utils import fragment_list_to_text
from prompt_toolkit.history import FileHistory, History, InMemoryHistory
from prompt_toolkit.key_binding import KeyBindings, KeyPressEvent
from prompt_toolkit.layout.processors import (
    HighlightMatchingBracketProcessor,
    Processor,
    Transformation,
    TransformationInput,
)
from prompt_toolkit.layout.utils import explode_text_fragments
from prompt_toolkit.lexers import PygmentsLexer
from prompt_toolkit.patch_stdout import patch_stdout
from prompt_toolkit.styles import Style

from scenelang.grammar.datum import Source
from scenelang.grammar.reader import Completeness, read
from scenelang.interpreter.expand.forms import INDENTS
from scenelang.interpreter.expand.scope import Macro
from scenelang.interpreter.loading import user_folder
from scenelang.interpreter.runtime.procedures import Closure
from scenelang.interpreter.runtime.types import Builtin
from scenelang.interpreter.scene.primitives import docs_of_words
from scenelang.reference.highlight import SceneLexer
from scenelang.reference.primer import attribute_doc, attribute_names, attributes_of
from scenelang.repl.commands import commands
from scenelang.repl.display import Screen, protocol_of, signature_of
from scenelang.repl.evaluation import ReplEvaluation, function_of
from scenelang.repl.loop import Quit, Repl, RequestReader, is_command, plain_request

if TYPE_CHECKING:
    from scenelang.repl.evaluation import ReplEvaluation
    from scenelang.stdlib.reference import ReferenceRecord


# Completions at the cursor: names, words in strings, attributes, commands, files; each with a brief description.


# Bracket matching in the text being typed.


_CLOSERS = {")": "(", "]": "["}


@dataclass(frozen=True, slots=True)
class Scan:
    """Result of a bracket scan.

    ``openers`` contains the offsets of unclosed brackets, ``wrong`` those of unmatched or mismatched closing brackets.
    ``string`` is the start of an unterminated string, if any; ``is_comment`` whether the text ends inside a comment.
    """

    openers: tuple[int, ...]
    wrong: tuple[int, ...]
    string: int | None
    is_comment: bool


def scan(text: str) -> Scan:
    """Scan a text once."""
    openers: list[int] = []
    wrong: list[int] = []
    position, end = 0, len(text)
    string: int | None = None
    is_comment = False
    while position < end:
        c = text[position]
        if c == '"':
            after = _string_end(text, position)
            if after is None:
                string = position
                break
            position = after
            continue
        if c == ";":
            newline = text.find("\n", position)
            if newline < 0:
                is_comment = True
                break
            position = newline
        elif c == "#" and text[position : position + 2] == "#|":
            block = _block_end(text, position)
            if block is None:
                is_comment = True
                break
            position = block
            continue
        elif c in "([":
            openers.append(position)
        elif c in ")]":
            if openers and text[openers[-1]] == _CLOSERS[c]:
                openers.pop()
            else:
                wrong.append(position)
        position += 1
    return Scan(tuple(openers), tuple(wrong), string, is_comment)


def _string_end(text: str, start: int) -> int | None:
    position = start + 1
    while position < len(text):
        if text[position] == "\\":
            position += 1
        elif text[position] == '"':
            return position + 1
        position += 1
    return None


def _block_end(text: str, start: int) -> int | None:
    depth, position = 0, start
    while position < len(text):
        pair = text[position : position + 2]
        if pair == "#|":
            depth, position = depth + 1, position + 2
        elif pair == "|#":
            depth, position = depth - 1, position + 2
            if depth == 0:
                return position
        else:
            position += 1
    return None


_SYMBOL = re.compile(r"[^\s()\[\]\"';`,]*\Z")
_WORD_PLACE = re.compile(r"\(\s*(?:call|bind|retrieve|scene|primitive|bound\?)\s+\Z")
_CALLED = re.compile(r'\(\s*(?:call|primitive)\s+"((?:[^"\\]|\\.)*)"')
_COMMAND_HEAD = re.compile(r"\(\s*([^\s()\[\]\"';`,]+)")
_MAX_META_LENGTH = 80


class SceneCompleter(Completer):
    """Completer for prompt_toolkit, based on the current state of the session."""

    def __init__(self, evaluation: ReplEvaluation) -> None:
        self._evaluation = evaluation
        self._paths = PathCompleter(expanduser=True)

    def get_completions(self, document: Document, complete_event: CompleteEvent) -> Iterator[Completion]:
        text = document.text_before_cursor
        if is_command(text) or text.strip() == ",":
            yield from self._in_command(text, document, complete_event)
            return
        yield from self._in_form(text)

    def _in_command(self, text: str, document: Document, event: CompleteEvent) -> Iterator[Completion]:
        name, blank, rest = text.lstrip()[1:].partition(" ")
        if not blank:
            offered = [(f",{command.name}", command.doc) for command in commands()]
            yield from _matching(f",{name}", offered)
            return
        command = next((c for c in commands() if c.name.startswith(name.rstrip("!"))), None)
        if command is not None and command.operand == "FILE":
            yield from self._paths.get_completions(Document(rest.lstrip('"')), event)
        elif command is not None and command.operand == "COMMAND":
            yield from _matching(rest, [(c.name, c.doc) for c in commands()])
        elif command is not None:
            yield from self._in_form(rest)

    def _in_form(self, text: str) -> Iterator[Completion]:
        scanned = scan(text)
        if scanned.is_comment:
            return
        if scanned.string is not None:
            if _WORD_PLACE.search(text[: scanned.string]):
                yield from _matching(text[scanned.string + 1 :], self._words())
            return
        match = _SYMBOL.search(text)
        prefix = match[0] if match is not None else ""
        if prefix.startswith(":"):
            opener = text[scanned.openers[-1] :] if scanned.openers else ""
            yield from _matching(prefix, self._attributes(opener))
        else:
            yield from _matching(prefix, self._names())

    # --- candidates --------------------------------------------------------------------------------------------

    def _words(self) -> Iterator[tuple[str, str]]:
        top = self._evaluation.top
        for word, cell in top.rt.words.items():
            if cell.function is not None:
                function = cell.function
                yield word, signature_of(function) if type(function) is Closure else "a word"
        for word, doc in docs_of_words().items():
            if word not in top.rt.words or top.rt.words[word].function is None:
                yield word, doc

    def _attributes(self, opener: str) -> Iterator[tuple[str, str]]:
        """Yield keywords of the called function or attributes of the called word; outside of calls, all attributes."""
        if not opener:
            yield from ((f":{name}", attribute_doc(None, name) or "") for name in attribute_names())
            return
        called = _CALLED.match(opener)
        top = self._evaluation.top
        if called is not None:
            function = function_of(top, f'"{called[1]}"')
            if function is not None:
                yield from ((f":{p.name}", _type(p)) for p in function.code.parameters if p.kind == "keyword")
                return
            yield from ((f":{name}", attribute_doc(called[1], name) or "") for name in attributes_of(called[1]))
            return
        head = _COMMAND_HEAD.match(opener)
        if head is None:
            return
        own = function_of(top, head[1])
        if own is not None:
            yield from ((f":{p.name}", _type(p)) for p in own.code.parameters if p.kind == "keyword")
            return
        for record in _library():
            if record.name == head[1]:
                yield from ((f":{keyword}", record.doc) for keyword in record.keywords)

    def _names(self) -> Iterator[tuple[str, str]]:
        top = self._evaluation.top
        seen: set[str] = set()
        for name, binding in top.names():
            if isinstance(binding, Builtin) or "|" in name:
                continue
            seen.add(name)
            function = function_of(top, name)
            kind = "macro" if isinstance(binding, Macro) else "defined in this session"
            yield name, signature_of(function) if function is not None else kind
        yield from ((record.name, record.doc) for record in _library() if record.name not in seen)


@cache
def _library() -> tuple[ReferenceRecord, ...]:
    """Return all names visible to programs without an import."""
    from scenelang.stdlib.reference import RecordKind, records

    return tuple(record for record in records() if record.module is None and record.kind is not RecordKind.TYPE)


def _type(parameter: Any) -> str:
    return str(parameter.type.name) if parameter.type is not None else ""


def _matching(prefix: str, offered: Iterable[tuple[str, str]]) -> Iterator[Completion]:
    """Return matches of the prefix by name first, then names that contain it."""
    rows = sorted(dict(offered).items())
    matches = [row for row in rows if row[0].startswith(prefix)]
    held = [row for row in rows if len(prefix) > 2 and prefix in row[0][1:] and row not in matches]
    for text, doc in [*matches, *held]:
        meta = " ".join(doc.split())
        yield Completion(text, -len(prefix), display_meta=meta[:_MAX_META_LENGTH])


# Indentation of a new line in an unfinished form: bodies by two columns, operands aligned with one another.


_HEAD = re.compile(r"[^\s()\[\]\"';`,]+")
_BLANK = re.compile(r"[ \t]*")
_CLAUSES = ("cond", "case")  # forms with clauses of a test and a body


def indentation(text: str, indents: Mapping[str, int | None]) -> int:
    """Return the indentation of the line after ``text``. ``indents`` maps each form to the number of operands on the
    head's line before its body, or None if operands are aligned."""
    scanned = scan(text)
    if not scanned.openers or scanned.string is not None:
        return 0
    opener = scanned.openers[-1]
    column = opener - (text.rfind("\n", 0, opener) + 1)
    if text[opener] == "[":
        return column + 1
    head = _HEAD.match(text, opener + 1)
    if head is None:
        return column + 1
    name, after = head[0], text[head.end() :]
    around = _HEAD.match(text, scanned.openers[-2] + 1) if len(scanned.openers) > 1 else None
    if around is not None and around[0] in _CLAUSES:
        return column + 1
    if name == "let" and re.match(r"\s+[^\s()]", after):
        return _body(column, after, 2)  # a named let
    head_operands = indents.get(name, 0 if name.startswith(("def", "with-")) else None)
    if head_operands is not None:
        return _body(column, after, head_operands)
    blank = _BLANK.match(text, head.end())
    start = blank.end() if blank is not None else head.end()
    if start >= len(text) or text[start] in "\n;":
        return column + (1 if name == "else" else 2)
    return column + start - opener


def _body(column: int, after: str, head_operands: int) -> int:
    """Indent a body by two columns, and distinguished operands before it by four."""
    return column + (2 if _operands(after) >= head_operands else 4)


def _operands(text: str) -> int:
    """Return the number of complete operands in the text after a head."""
    count, position = 0, 0
    while True:
        while position < len(text) and text[position].isspace():
            position += 1
        if position >= len(text):
            return count
        start = position
        if text[position] in '(["':
            position = _datum_end(text, position)
        else:
            atom = re.compile(r"[^\s()\[\]\"]+").match(text, position)
            position = atom.end() if atom is not None else position + 1
        count += position > start


def _datum_end(text: str, start: int) -> int:
    """Return the end of the list or string that starts at ``start``, or the end of the text if it is unclosed."""
    if text[start] == '"':
        match = re.compile(r'"(?:[^"\\]|\\.)*"').match(text, start)
        return match.end() if match is not None else len(text)
    low, high = start + 1, len(text)
    for close in re.finditer(r"[)\]]", text[low:high]):
        end = low + close.end()
        scanned = scan(text[start:end])
        if not scanned.openers and scanned.string is None:
            return end
    return len(text)


PROMPT = "scene> "
_STYLE = Style.from_dict({"wrong-bracket": "bg:ansired ansiwhite", "prompt": "ansicyan"})


def run(evaluation: ReplEvaluation, color: bool, quiet: bool, request: RequestReader = plain_request) -> int:
    """Run until Ctrl-D or ``,quit``; returns the number of failed inputs."""
    screen = Screen(_write, _write, color, protocol_of(os.environ), _ask, quiet)
    repl = Repl(evaluation, screen, commands(), request)
    session = _session(evaluation, color=color)
    repl.wake = lambda: _wake(repl, session.app)
    if not quiet:
        _write("The Scene Language. `,help` lists the commands, Ctrl-D exits.")
    try:
        repl.open()
        text = ""
        while True:
            text = _one_input(repl, session, text)
    except (EOFError, Quit):
        return repl.errors
    finally:
        repl.close()


def _one_input(repl: Repl, session: PromptSession[str], text: str) -> str:
    """Read and process an input, which begins with ``text``; returns the beginning of the next one."""
    start = lambda: _wake(repl, session.app)
    try:
        with patch_stdout(raw=True):
            text = session.prompt([("class:prompt", PROMPT)], default=text, pre_run=start)
        if text.strip():
            repl.feed(text)
    except KeyboardInterrupt:
        pass
    except _Replaced:
        return session.default_buffer.text
    return ""


class _Replaced(Exception):
    """Raised by a prompt that this process has inherited from a killed one."""


def _wake(repl: Repl, app: Application[str]) -> None:
    """Have the running prompt do what background threads ask for; another one does it when it starts."""
    if app.is_running and app.loop is not None and repl.is_asked:
        with suppress(RuntimeError):  # it has just ended
            app.loop.call_soon_threadsafe(lambda: app.create_background_task(_work(repl, app)))


async def _work(repl: Repl, app: Application[str]) -> None:
    before = repl.evaluation.replacements
    loop = asyncio.get_running_loop()

    def act() -> None:
        _work_in_terminal(repl)
        asyncio._set_running_loop(loop)  # which asyncio does not take for running after a fork

    await run_in_terminal(act)
    if repl.evaluation.replacements != before:
        app.exit(exception=_Replaced)


def _work_in_terminal(repl: Repl) -> None:
    """Work without the thread of ``patch_stdout``, which does not survive a fork. Ctrl-C interrupts."""
    handler = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with redirect_stdout(sys.__stdout__), redirect_stderr(sys.__stderr__):
            repl.work()
    except KeyboardInterrupt:
        return
    finally:
        signal.signal(signal.SIGINT, handler)


def _write(text: str) -> None:
    print(text, flush=True)


def _ask(question: str) -> bool:
    answer = input(f"{question} [y/N] ")
    return answer.strip().lower() in ("y", "yes")


def _session(evaluation: ReplEvaluation, *, color: bool) -> PromptSession[str]:
    session: PromptSession[str] = PromptSession(
        history=_history(),
        multiline=True,
        key_bindings=_keys(),
        lexer=PygmentsLexer(SceneLexer) if color else None,
        completer=SceneCompleter(evaluation),
        complete_while_typing=False,
        enable_history_search=True,
        input_processors=[HighlightMatchingBracketProcessor(chars="[](){}"), _WrongBrackets()],
        prompt_continuation=lambda width, number, is_soft: " " * width,
        style=_STYLE,
        include_default_pygments_style=color,
    )
    return session


def _keys() -> KeyBindings:
    keys = KeyBindings()
    is_typing = Condition(lambda: not get_app().layout.is_searching and get_app().current_buffer.complete_state is None)

    @keys.add("enter", filter=is_typing)
    def _(event: KeyPressEvent) -> None:
        buffer = event.current_buffer
        if is_finished(buffer.text):
            buffer.validate_and_handle()
        else:
            columns = indentation(buffer.document.text_before_cursor, INDENTS)
            buffer.insert_text("\n" + " " * columns)

    @keys.add("escape", "enter")
    def _(event: KeyPressEvent) -> None:
        buffer = event.current_buffer
        buffer.insert_text("\n" + " " * indentation(buffer.document.text_before_cursor, INDENTS))

    return keys


def is_finished(text: str) -> bool:
    """Return whether Enter submits a text: a command, complete forms, or an error that more text cannot fix."""
    if not text.strip() or is_command(text):
        return True
    return read(Source("<repl>", text)).completeness is not Completeness.INCOMPLETE


class _WrongBrackets(Processor):
    """Highlights unmatched and mismatched closing brackets."""

    def apply_transformation(self, transformation_input: TransformationInput) -> Transformation:
        document = transformation_input.document
        fragments: StyleAndTextTuples = transformation_input.fragments
        wrong = scan(document.text).wrong if not is_command(document.text) else ()
        if not wrong:
            return Transformation(fragments)
        start = document.translate_row_col_to_index(transformation_input.lineno, 0)
        exploded = explode_text_fragments(fragments)
        length = len(fragment_list_to_text(exploded))
        for offset in wrong:
            if 0 <= offset - start < length:
                style, text, *_ = exploded[offset - start]
                exploded[offset - start] = (f"{style} class:wrong-bracket", text)
        return Transformation(exploded)


# --- history -------------------------------------------------------------------------------------------------------


def history_path() -> Path:
    """Return the path of the history file."""
    return user_folder("STATE") / "history"


def _history() -> History:
    """History in a file readable only by its owner; in memory if the file cannot be written."""
    path = history_path()
    try:
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        os.close(os.open(path, os.O_CREAT | os.O_RDWR, 0o600))
        path.chmod(0o600)
    except OSError:
        return InMemoryHistory()
    return FileHistory(str(path))
