"""Shell completion with argcomplete, and completers for the values of arguments."""

from __future__ import annotations

import argparse
import os
import re
import shlex
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

from argcomplete import autocomplete, finders
from argcomplete.completers import SuppressCompleter

from scenelang.grammar.lazy_patterns import lazy_pattern

Completer = Callable[..., Iterable[str]]
_PROGRAMS = (".scene", ".py", ".txt", ".ipynb", ".json")  # file extensions of programs
# Pictures are a domain that the kernel does not import.
_CAMERAS = (
    "three-quarter", "hero", "catalogue", "isometric", "plan", "elevation",
    "front", "right", "back", "left", "top", "bottom", "turntable", "follow",
)  # fmt: skip
_CLEAR_GROUNDS = ("transparent", "shadow")
_BINDING = lazy_pattern(r'\(bind\s+"([^"]*)"')


def complete(build_parser: Callable[[str], argparse.ArgumentParser]) -> None:
    """Answer the shell's completion request from the environment and exit the process.

    Parameters
    ----------
    build_parser
        Creates the parser that has the arguments of one command, given its name.
    """
    line = os.environ["COMP_LINE"][: int(os.environ["COMP_POINT"])]
    words = [word for word in re.findall(r"(\S+)\s", line)[1:] if not word.startswith("-")]
    parser = build_parser(words[0] if words else "")
    # An argument counts as given only if its action is known to have no side effects, as those with a value.
    finders.safe_actions |= {type(action) for action in _actions(parser) if action.nargs != 0}
    _teach(parser)
    autocomplete(parser, always_complete_options=False, default_completer=SuppressCompleter())


def subcommands(parser: argparse.ArgumentParser) -> dict[str, tuple[argparse.ArgumentParser, str]]:
    """Return the subparsers of a parser's commands with their one-line help."""
    parsers: dict[str, tuple[argparse.ArgumentParser, str]] = {}
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            briefs = {choice.dest: choice.help or "" for choice in action._choices_actions}
            parsers |= {name: (child, briefs.get(name, "")) for name, child in action.choices.items()}
    return parsers


def _actions(parser: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    """Yield the arguments of a parser and of its subparsers, without those that are commands."""
    yield from (action for action in parser._actions if not isinstance(action, argparse._SubParsersAction))
    for child, _ in subcommands(parser).values():
        yield from _actions(child)


def _teach(parser: argparse.ArgumentParser) -> None:
    """Attach a completer to every argument whose values are known."""
    for action in parser._actions:
        if action.choices is None and action.nargs != 0:
            setattr(action, "completer", _completer(action))  # noqa: B010 - an attribute of argcomplete's
    for child, _ in subcommands(parser).values():
        _teach(child)


def _completer(action: argparse.Action) -> Completer:
    """Return the completer of an argument, by its name or metavar."""
    metavar = action.metavar if isinstance(action.metavar, str) else ""
    if action.dest in _KNOWN:
        return _KNOWN[action.dest]
    if action.option_strings and "|" in metavar:
        return lambda **_: metavar.split("|")
    if metavar == "DIR":
        return _files()
    if not action.option_strings and metavar in ("FILE", "A", "B", "PATH"):
        return _files(*_PROGRAMS)
    return _files("") if metavar.startswith(("FILE", "OUT", "PATH")) else _nothing


def _nothing(**_: Any) -> Iterable[str]:
    """Complete nothing."""
    return ()


def _files(*endings: str) -> Completer:
    """Return a completer for folders, and for files with one of the extensions."""

    def find(prefix: str, **_: Any) -> Iterator[str]:
        """Yield the paths that begin with a prefix."""
        start = prefix.rpartition("/")[2]
        folder = prefix.removesuffix(start)
        place = Path(folder).expanduser()
        try:
            paths = sorted(place.iterdir())
        except OSError:
            return
        for path in paths:
            if path.name.startswith(start) and (start or not path.name.startswith(".")):
                shown = folder + path.name
                if path.is_dir():
                    yield f"{shown}/"
                elif path.name.endswith(endings):
                    yield shown

    return find


def _words(**_: Any) -> Iterator[str]:
    """Yield the words bound by the programs on the command line."""
    line = os.environ["COMP_LINE"]
    try:
        names = shlex.split(line)
    except ValueError:  # an unterminated quotation
        names = line.split()
    for path in (Path(name) for name in names if name.endswith(".scene")):
        if path.is_file():
            yield from _BINDING.findall(path.read_text("utf-8", "replace"))


def _backends(**_: Any) -> Iterable[str]:
    """Return the names of backends."""
    from scenelang.backends import base

    return base.names()


def _environments(**_: Any) -> Iterable[str]:
    """Return the names of lighting environments."""
    from scenelang.backends.surfaces.environments import ENVIRONMENTS

    return ENVIRONMENTS


def _grounds(**_: Any) -> Iterable[str]:
    """Return the names of grounds."""
    from scenelang.backends.surfaces.environments import GROUNDS

    return (*GROUNDS, *_CLEAR_GROUNDS)


def _codes(**_: Any) -> Iterable[str]:
    """Return the codes and names of diagnostics."""
    from scenelang.grammar.diagnostics import CODES

    return [text for name, entry in CODES.items() for text in (entry.code, name)]


_KNOWN: dict[str, Completer] = {
    "root": _words,
    "word": _words,
    "z": _files(".safetensors"),
    "backend": _backends,
    "environment": _environments,
    "ground": _grounds,
    "camera": lambda **_: _CAMERAS,
    "codes": _codes,
}
