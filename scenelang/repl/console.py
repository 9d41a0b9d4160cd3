"""The REPL in a terminal: editing of several lines, history, colours, brackets, completion."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from pathlib import Path

from prompt_toolkit import PromptSession
from prompt_toolkit.application import get_app
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

from scenelang.backends.files import user_folder
from scenelang.grammar.datum import Source
from scenelang.grammar.reader import Completeness, read
from scenelang.highlight import SceneLexer
from scenelang.interpreter.expand.forms import INDENTS
from scenelang.repl.commands import commands
from scenelang.repl.completion import SceneCompleter, scan
from scenelang.repl.display import Screen, protocol_of
from scenelang.repl.evaluation import ReplEvaluation
from scenelang.repl.loop import Quit, Repl, RequestReader, is_command, plain_request

# How far a new line of an unfinished form is indented: bodies by two, operands under one another.


_HEAD = re.compile(r"[^\s()\[\]\"';`,]+")
_BLANK = re.compile(r"[ \t]*")
_CLAUSES = ("cond", "case")  # whose operands are lists of a test and a body


def indentation(text: str, indents: Mapping[str, int | None]) -> int:
    """Columns for the line that follows ``text``. ``indents``: for each form how many operands stand on the head's line
    before its body, None where operands are aligned."""
    found = scan(text)
    if not found.openers or found.string is not None:
        return 0
    opener = found.openers[-1]
    column = opener - (text.rfind("\n", 0, opener) + 1)
    if text[opener] == "[":
        return column + 1
    head = _HEAD.match(text, opener + 1)
    if head is None:
        return column + 1
    name, after = head[0], text[head.end() :]
    around = _HEAD.match(text, found.openers[-2] + 1) if len(found.openers) > 1 else None
    if around is not None and around[0] in _CLAUSES:
        return column + 1
    if name == "let" and re.match(r"\s+[^\s()]", after):
        return _body(column, after, 2)  # a named let
    wanted = indents.get(name, 0 if name.startswith(("def", "with-")) else None)
    if wanted is not None:
        return _body(column, after, wanted)
    blank = _BLANK.match(text, head.end())
    start = blank.end() if blank is not None else head.end()
    if start >= len(text) or text[start] in "\n;":
        return column + (1 if name == "else" else 2)
    return column + start - opener


def _body(column: int, after: str, wanted: int) -> int:
    """A body by two; what belongs on the head's line but does not stand there by four."""
    return column + (2 if _operands(after) >= wanted else 4)


def _operands(text: str) -> int:
    """How many operands are complete in the text after a head."""
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
    """Where the list or string that begins at ``start`` ends, the end of the text when it is open."""
    if text[start] == '"':
        match = re.compile(r'"(?:[^"\\]|\\.)*"').match(text, start)
        return match.end() if match is not None else len(text)
    low, high = start + 1, len(text)
    for close in re.finditer(r"[)\]]", text[low:high]):
        end = low + close.end()
        found = scan(text[start:end])
        if not found.openers and found.string is None:
            return end
    return len(text)


PROMPT = "scene> "
_STYLE = Style.from_dict({"wrong-bracket": "bg:ansired ansiwhite", "prompt": "ansicyan"})


def run(evaluation: ReplEvaluation, color: bool, quiet: bool, request: RequestReader = plain_request) -> int:
    """Work until Ctrl-D or ``,quit``; how many inputs failed."""
    screen = Screen(_write, _write, color, protocol_of(os.environ), _ask, quiet)
    repl = Repl(evaluation, screen, commands(), request)
    session = _session(evaluation, color)
    if not quiet:
        _write("The Scene Language. `,help` lists the commands, Ctrl-D leaves.")
    try:
        repl.open()
        while True:
            _one_input(repl, session)
    except (EOFError, Quit):
        return repl.errors
    finally:
        repl.close()


def _one_input(repl: Repl, session: PromptSession[str]) -> None:
    try:
        with patch_stdout(raw=True):
            text = session.prompt([("class:prompt", PROMPT)])
        if text.strip():
            repl.feed(text)
    except KeyboardInterrupt:
        return


def _write(text: str) -> None:
    print(text, flush=True)


def _ask(question: str) -> bool:
    answer = input(f"{question} [y/N] ")
    return answer.strip().lower() in ("y", "yes")


def _session(evaluation: ReplEvaluation, color: bool) -> PromptSession[str]:
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
    """Whether Enter sends a text: a command, complete forms, or something that no more text can mend."""
    if not text.strip() or is_command(text):
        return True
    return read(Source("<repl>", text)).completeness is not Completeness.INCOMPLETE


class _WrongBrackets(Processor):
    """Marks closing brackets that close nothing, or the wrong kind."""

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
    """Where inputs are kept from session to session."""
    return user_folder("STATE") / "history"


def _history() -> History:
    """A file that only its owner reads; only this session's inputs where it cannot be written."""
    path = history_path()
    try:
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        os.close(os.open(path, os.O_CREAT | os.O_RDWR, 0o600))
        path.chmod(0o600)
    except OSError:
        return InMemoryHistory()
    return FileHistory(str(path))
