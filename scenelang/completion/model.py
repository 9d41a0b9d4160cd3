"""What a shell must know of the commands: names, options and what their values are, read off argparse."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum

from scenelang.cli.backend_options import add_now

PROGRAMS = ("scene", "py", "txt", "json")  # endings of what commands read as a program
WORDS = ("root", "word")  # options whose value is a word that the program binds


class Values(Enum):
    """What an argument's values are, as far as a shell can help."""

    NONE = "none"  # a flag: there is no value
    ANY = "any"  # nothing is known
    CHOICES = "choices"
    FILES = "files"
    FOLDERS = "folders"
    WORDS = "words"


@dataclass(frozen=True, slots=True)
class Argument:
    """One option (``flags`` as written) or positional argument. ``endings``: of files, without dots, () for any."""

    flags: tuple[str, ...]
    label: str
    help: str
    values: Values
    choices: tuple[str, ...] = ()
    endings: tuple[str, ...] = ()
    repeats: bool = False


@dataclass(frozen=True, slots=True)
class Command:
    name: str
    help: str
    options: tuple[Argument, ...]
    positionals: tuple[Argument, ...]


def commands_of(parser: argparse.ArgumentParser, known: Mapping[str, Sequence[str]]) -> tuple[Command, ...]:
    """Every command of a parser. ``known``: values of options that take any text, by the option's name."""
    found = []
    for name, (child, brief) in subcommands(parser).items():
        arguments = list(_arguments(child, known))
        found.append(
            Command(
                name,
                brief,
                tuple({argument.flags: argument for argument in arguments if argument.flags}.values()),
                tuple(argument for argument in arguments if not argument.flags),
            )
        )
    return tuple(found)


def subcommands(parser: argparse.ArgumentParser) -> dict[str, tuple[argparse.ArgumentParser, str]]:
    """The parsers and the lines of help of a parser's commands, with all that ``add_later`` held back."""
    found = {}
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            briefs = {choice.dest: choice.help or "" for choice in action._choices_actions}
            for name, child in action.choices.items():
                add_now(child)
                found[name] = (child, briefs.get(name, ""))
    return found


def _arguments(parser: argparse.ArgumentParser, known: Mapping[str, Sequence[str]]) -> Iterator[Argument]:
    """The arguments of a command; where it has commands of its own these are choices, and their options follow."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            yield Argument((), action.dest, "", Values.CHOICES, tuple(action.choices))
            for child, _ in subcommands(parser).values():
                yield from (argument for argument in _arguments(child, known) if argument.flags)
        else:
            yield _argument(action, known)


def _argument(action: argparse.Action, known: Mapping[str, Sequence[str]]) -> Argument:
    metavar = action.metavar if isinstance(action.metavar, str) else action.dest.upper()
    values, choices, endings = _values(action, metavar, known)
    text = " ".join((action.help or "").replace("%%", "%").split())
    repeats = action.nargs in ("*", "+")
    return Argument(tuple(action.option_strings), metavar, text, values, choices, endings, repeats)


def _values(
    action: argparse.Action, metavar: str, known: Mapping[str, Sequence[str]]
) -> tuple[Values, tuple[str, ...], tuple[str, ...]]:
    if action.nargs == 0:
        return Values.NONE, (), ()
    if action.choices is not None:
        return Values.CHOICES, tuple(str(choice) for choice in action.choices), ()
    if action.dest in known:
        return Values.CHOICES, tuple(known[action.dest]), ()
    if action.option_strings and "|" in metavar:
        return Values.CHOICES, tuple(metavar.split("|")), ()
    if action.dest in WORDS:
        return Values.WORDS, (), ()
    if metavar == "DIR":
        return Values.FOLDERS, (), ()
    if not action.option_strings and metavar in ("FILE", "A", "B", "PATH"):
        return Values.FILES, (), PROGRAMS
    if action.dest == "z":
        return Values.FILES, (), ("safetensors",)
    if metavar.startswith(("FILE", "OUT", "PATH")):
        return Values.FILES, (), ()
    return Values.ANY, (), ()
