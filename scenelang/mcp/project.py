"""The one folder that an agent may read from, and programs in it."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from scenelang.grammar.diagnostics import SceneError, printable
from scenelang.grammar.source import Source
from scenelang.interpreter.limits import Limits
from scenelang.session import Options, Session
from scenelang.zfile import beside, read_entries

if TYPE_CHECKING:
    from scenelang.interpreter.runtime import Entry

_NAME = "<program>"
_LONGEST_PROGRAM = 1_000_000  # characters; no model writes more, and what is larger can lie in a file
_SHOWN = 120


class WrongArguments(Exception):
    """A call that makes no sense, whatever the program. Its text is one line for the agent."""


def wrong_arguments(error: SceneError) -> WrongArguments:
    """A SceneError about the arguments of a call, as one line."""
    return WrongArguments("; ".join(part for part in (error.message, error.hint) if part))


@dataclass(frozen=True, slots=True)
class Program:
    """What a call is about: the text of a program, or a file. Exactly one is given, the other is empty. ``root`` is the
    word to evaluate (empty: the program's own)."""

    text: str = ""
    path: str = ""
    root: str = ""


@dataclass(frozen=True, slots=True)
class Project:
    """The folder ``root``, resolved, and what evaluations in it may use. It is the working folder of the process too,
    so that what a program imports is looked for in it."""

    root: Path
    limits: Limits

    def file(self, path: str) -> Path:
        """The regular file of that path, links followed; raises WrongArguments for what is none, or lies outside."""
        shown = printable(path[:_SHOWN]).replace("\n", " ")
        try:
            target = (self.root / path).resolve()
            is_inside, is_file = target.is_relative_to(self.root), target.is_file()
        except (OSError, ValueError, RuntimeError):
            raise WrongArguments(f"`{shown}` is no path") from None
        if not is_inside:
            raise WrongArguments(f"`{shown}` leads out of the project folder")
        if not is_file:
            raise WrongArguments(f"there is no file `{shown}` in the project folder")
        return target

    def opened(self, program: Program) -> tuple[Session, Source]:
        """The session and the source to check or evaluate. Raises WrongArguments for a call that names no program,
        SceneError for a file that holds none."""
        if bool(program.text) == bool(program.path):
            raise WrongArguments("give either `program`, the text, or `path`, a file of the project folder")
        if program.text:
            return self._session(program, {}), Source(_NAME, _checked(program.text))
        file = self.file(program.path)
        session = self._session(program, self._embeddings(file))
        return session, Source(str(file.relative_to(self.root)), session.source(str(file)).text)

    def _session(self, program: Program, entries: dict[str, Entry]) -> Session:
        return Session(Options(root=program.root or None, limits=self.limits, project=self.root, z_entries=entries))

    def _embeddings(self, file: Path) -> dict[str, Entry]:
        """Z of a program, as on the command line: what lies beside it."""
        z = beside(str(file))
        return read_entries(self.file(str(z))) if os.path.exists(z) else {}


def _checked(text: str) -> str:
    if len(text) > _LONGEST_PROGRAM:
        raise WrongArguments(
            f"`program` is longer than {_LONGEST_PROGRAM:,} characters; save it as a file, give `path`"
        )
    return text
