"""Declarations of spatial relations as text, such as ``(on "cup" "table")``."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING

from scenelang.grammar.datum import Source, replace
from scenelang.grammar.diagnostics import Diagnostic, SceneError
from scenelang.grammar.lazy_patterns import lazy_pattern
from scenelang.interpreter.scene.declarations import RELATIONS
from scenelang.session.session import Options, Session

if TYPE_CHECKING:
    from scenelang.interpreter.scene.declarations import Declaration


_NAME_IN_PATH = lazy_pattern(r"[\w-]+")
_BARE = lazy_pattern(r"\s*\(\s*(?:not\s*\(\s*)?([^\s()]+)")  # a relation outside of `assert-that`


def declarations_of(session: Session, asked: str) -> tuple[Declaration, ...]:
    """Return the declarations of a text such as ``(on "cup" "table")``, or of a file of these or ``assert-that`` forms.

    Raises SceneError with the first mistake.
    """
    from pathlib import Path

    _check_form(asked)
    source = declaration_source(asked) if asked.lstrip().startswith("(") else session.source(asked)
    bare = _BARE.match(source.text)
    if bare is not None and bare[1] in RELATIONS:
        source = Source(source.name, declaration_source(source.text.strip()).text)
    try:
        declarations = session.declarations(source)
    except SceneError as error:
        quoted = _with_quotes(session, asked) if error.name in ("unbound", "type", "word") else None
        if quoted is None:
            raise
        message = f"words need quotes, got `{asked[:_MAX_SHOWN]}`: perhaps the shell has removed them"
        raise SceneError(error.name, message, f"write `--that '{quoted}'`") from None
    if not declarations:
        hint = 'write `(assert-that (on "cup" "table"))`'
        raise SceneError("value", f"{Path(source.name).name} states no declaration", hint)
    return declarations


def _check_form(asked: str) -> None:
    """Raise SceneError for a text that is neither a form nor a file, such as ``on cup table``."""
    import os

    if asked.lstrip().startswith("(") or os.path.lexists(asked) or not (" " in asked.strip() or asked in RELATIONS):
        return
    written = declaration_of_words(asked) or '(on "cup" "table")'
    message = f"a declaration is a form in parentheses, with words in quotes, got `{asked[:_MAX_SHOWN]}`"
    raise SceneError("value", message, f"write `--that '{written}'`, or name a file of such forms")


def declaration_of_words(text: str) -> str | None:
    """Return the declaration that ``on cup table`` or ``cup on table`` means, None if no relation is named."""
    words = _WORDS.findall(text.strip().removeprefix("(").removesuffix(")"))
    relation = next((word for word in words if word in RELATIONS), None)
    if relation is None:
        return None
    at = words.index(relation)
    things = [word.strip("\"'") for word in words[:at] + words[at + 1 :]]
    form = f"({relation} {' '.join(thing if _IS_PLAIN.fullmatch(thing) else _string(thing) for thing in things)})"
    return form if declaration_problem(form) is None else None


def _string(text: str) -> str:
    """Return a string of the language."""
    return f'"{text}"'


_WORDS = lazy_pattern(r'"[^"]*"|[^\s"]+')
_IS_PLAIN = lazy_pattern(r"[-+]?[\d.]+|:.*")  # numbers and keywords, which have no quotes
_MAX_SHOWN = 80  # characters of a declaration in a message
_OPERAND = lazy_pattern(r"""(?<=[\s(])(?![-+.\d:'"])[^\s()\[\]"']+(?=[\s)])""")


def _with_quotes(session: Session, asked: str) -> str | None:
    """Return a declaration with quotes around its words, if it is valid with them and had none; else None."""
    if '"' in asked or not asked.lstrip().startswith("("):
        return None
    quoted = _OPERAND.sub(lambda match: match[0] if asked[match.start() - 1] == "(" else f'"{match[0]}"', asked)
    try:
        return quoted if session.declarations(declaration_source(quoted)) else None
    except SceneError:
        return None


def declaration_source(text: str) -> Source:
    """Return the source of a declaration such as ``(on "cup" "table")``."""
    return Source("<declaration>", text if text.lstrip().startswith("(assert-that") else f"(assert-that {text})")


_ACCEPTANCE = "; What must hold; every edit is tested against it."


def with_acceptance(program: str, declarations: Sequence[object]) -> str:
    """Return a program that states declarations about its scene at its end; it may state them already."""
    if not declarations:
        return program
    body = program.partition(_ACCEPTANCE)[0].rstrip()
    stated = "\n".join(f"  {_on_a_line(str(declaration))}" for declaration in declarations)
    return f"{body}\n\n{_ACCEPTANCE}\n(assert-that\n{stated})\n"


def without_acceptance(program: str) -> tuple[str, tuple[str, ...]]:
    """Return a program and the declarations that ``with_acceptance`` wrote at its end, apart from each other."""
    body, _, stated = program.partition(_ACCEPTANCE)
    texts = tuple(line.strip() for line in stated.strip().removesuffix(")").splitlines()[1:])
    return (f"{body.rstrip()}\n", texts) if texts and with_acceptance(body, texts) == program else (program, ())


def _on_a_line(text: str) -> str:
    """Return declarations on one line, without the form `assert-that` around them."""
    line = " ".join(text.split())
    return line.removeprefix("(assert-that").removesuffix(")").strip() if line.startswith("(assert-that") else line


def declaration_problem(text: str) -> Diagnostic | None:
    """Return the first mistake in a declaration, None if it is well formed."""
    try:
        Session().declarations(declaration_source(text))
    except SceneError as error:
        return error.diagnostic
    return None


def declarations_in(options: Options | None, texts: Sequence[str]) -> list[Declaration]:
    """Return the declarations in texts or files, read under the options of a scene; raises SceneError."""
    session = Session(options or Options())
    return [declaration for text in texts for declaration in declarations_of(session, text)]


def declared_in_python(declaration: Declaration, words: Collection[str]) -> Declaration:
    """Return a declaration about words as the names of Python's functions write them."""
    options = {
        key: _in_python(value, words) if key in ("about", "around") else value
        for key, value in declaration.options.items()
    }
    return replace(declaration, things=tuple(_in_python(t, words) for t in declaration.things), options=options)


def _in_python(word: str, words: Collection[str]) -> str:
    """Return the words of a path as the names of Python's functions write them, if the scene has only those."""
    return _NAME_IN_PATH.sub(lambda match: _python_name(match[0], words), word)


def _python_name(word: str, words: Collection[str]) -> str:
    written = word.replace("-", "_")
    return written if word not in words and written in words else word
