"""What can stand at the cursor: names, words in strings, attributes, commands, files; each with its doc in brief."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

from prompt_toolkit.completion import CompleteEvent, Completer, Completion, PathCompleter
from prompt_toolkit.document import Document

from scenelang.interpreter.expand.scope import Macro
from scenelang.interpreter.runtime.procedures import Closure
from scenelang.interpreter.runtime.types import Builtin
from scenelang.interpreter.scene.primitives import docs_of_words
from scenelang.primer import attribute_doc, attribute_names, attributes_of
from scenelang.repl.commands import commands
from scenelang.repl.display import signature_of
from scenelang.repl.evaluation import function_of
from scenelang.repl.loop import is_command

if TYPE_CHECKING:
    from scenelang.repl.evaluation import ReplEvaluation
    from scenelang.stdlib.reference import ReferenceRecord


# The brackets of a text that is being typed: which are open at its end, which closing ones are wrong.


_CLOSERS = {")": "(", "]": "["}


@dataclass(frozen=True, slots=True)
class Scan:
    """``openers`` are the offsets of the brackets that are open at the end, ``wrong`` those of closing brackets that
    close nothing or the wrong kind. ``string`` is where a string begins that is still open, ``is_comment`` whether the
    text ends inside a comment."""

    openers: tuple[int, ...]
    wrong: tuple[int, ...]
    string: int | None
    is_comment: bool


def scan(text: str) -> Scan:
    """Look through a text once."""
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
_HEAD = re.compile(r"\(\s*([^\s()\[\]\"';`,]+)")
_LONGEST_META = 80


class SceneCompleter(Completer):
    """Completions for prompt_toolkit, from what the session knows at the moment."""

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
            found = [(f",{command.name}", command.doc) for command in commands()]
            yield from _matching(f",{name}", found)
            return
        command = next((c for c in commands() if c.name.startswith(name.rstrip("!"))), None)
        if command is not None and command.operand == "FILE":
            yield from self._paths.get_completions(Document(rest.lstrip('"')), event)
        elif command is not None and command.operand == "COMMAND":
            yield from _matching(rest, [(c.name, c.doc) for c in commands()])
        elif command is not None:
            yield from self._in_form(rest)

    def _in_form(self, text: str) -> Iterator[Completion]:
        found = scan(text)
        if found.is_comment:
            return
        if found.string is not None:
            if _WORD_PLACE.search(text[: found.string]):
                yield from _matching(text[found.string + 1 :], self._words())
            return
        match = _SYMBOL.search(text)
        prefix = match[0] if match is not None else ""
        if prefix.startswith(":"):
            opener = text[found.openers[-1] :] if found.openers else ""
            yield from _matching(prefix, self._attributes(opener))
        else:
            yield from _matching(prefix, self._names())

    # --- what there is -----------------------------------------------------------------------------------------

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
        """Keywords of the function that is called, or attributes of the word; of any primitive outside of forms."""
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
        head = _HEAD.match(opener)
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
            kind = "macro" if isinstance(binding, Macro) else "of this session"
            yield name, signature_of(function) if function is not None else kind
        yield from ((record.name, record.doc) for record in _library() if record.name not in seen)


@cache
def _library() -> tuple[ReferenceRecord, ...]:
    """All that programs see without importing it."""
    from scenelang.stdlib.reference import RecordKind, records

    return tuple(record for record in records() if record.module is None and record.kind is not RecordKind.TYPE)


def _type(parameter: Any) -> str:
    return str(parameter.type.name) if parameter.type is not None else ""


def _matching(prefix: str, found: Iterable[tuple[str, str]]) -> Iterator[Completion]:
    """What begins with the prefix, by name; then what only holds it."""
    rows = sorted(dict(found).items())
    begun = [row for row in rows if row[0].startswith(prefix)]
    held = [row for row in rows if len(prefix) > 2 and prefix in row[0][1:] and row not in begun]
    for text, doc in [*begun, *held]:
        meta = " ".join(doc.split())
        yield Completion(text, -len(prefix), display_meta=meta[:_LONGEST_META])
