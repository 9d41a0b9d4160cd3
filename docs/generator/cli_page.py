"""The page of the command line, from the parser that the commands use."""

from __future__ import annotations

import argparse
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

from generator.markdown import NOTICE, anchor, table
from scenelang.cli.main import build_parser
from scenelang.console.shell_completion import subcommands

Options = tuple[tuple[str, str], ...]
_LONG = re.compile(r"--([a-z][a-z0-9-]*)")


def cli_page() -> str:
    """Every command with its options, Markdown."""
    commands = {command.name: command for command in _commands(build_parser())}
    shared = _shared(commands)
    lines = [
        "# The command line",
        "",
        NOTICE,
        "",
        "`scenelang COMMAND ...`, short `scene COMMAND ...`. The exit code is 0 on success, 1 for a wrong program or",
        "file, 2 for wrong usage, 130 after Ctrl-C, 141 if nothing reads the output any more, 143 after SIGTERM.",
        "",
    ]
    lines += table(
        ("command", ""),
        [(f"[`{name}`](#{anchor(name)})", _sentence(command)) for name, command in commands.items()],
    )
    for command in commands.values():
        lines += _section(command, shared)
    lines += ["## Options that commands share", ""]
    for (title, options), heading in shared.items():
        lines += [f"### {heading}", "", *table((title, ""), _anchored(f"options of {heading}", options))]
    return "\n".join(lines).rstrip("\n") + "\n"


@dataclass(frozen=True, slots=True)
class Command:
    """A command that has none of its own below it. ``usage`` is how it begins, with the arguments before its name."""

    name: str
    usage: str
    brief: str
    parser: argparse.ArgumentParser


def _commands(
    parser: argparse.ArgumentParser, name: tuple[str, ...] = (), usage: tuple[str, ...] = ()
) -> Iterator[Command]:
    before = tuple(_place(action) for action in parser._get_positional_actions() if action.choices is None)
    for own, (child, brief) in subcommands(parser).items():
        path, start = (*name, own), (*usage, *before, own)
        inner = list(_commands(child, path, start))
        yield from inner or [Command(" ".join(path), " ".join(start), brief, child)]


def _groups(parser: argparse.ArgumentParser) -> Iterator[tuple[str, Options]]:
    """The named groups of options of a command."""
    for group in parser._action_groups[2:]:
        options = tuple(_option(action) for action in group._group_actions)
        if options:
            yield group.title or "", options


def _shared(commands: Mapping[str, Command]) -> Mapping[tuple[str, Options], str]:
    """Groups that several commands have, with their headings."""
    count = Counter(group for command in commands.values() for group in _groups(command.parser))
    found = [group for group, times in count.items() if times > 1]
    same = Counter(title for title, _ in found)
    numbers: Counter[str] = Counter()
    headings = {}
    for title, options in found:
        numbers[title] += 1
        headings[title, options] = title.capitalize() + (f" {numbers[title]}" if same[title] > 1 else "")
    return headings


def _section(command: Command, shared: Mapping[tuple[str, Options], str]) -> Iterator[str]:
    parser = command.parser
    yield from (f"## {command.name}", "", f"`scenelang {command.usage}{_usage(parser)}`", "")
    yield from (_full_stop(parser.description) if parser.description else _sentence(command), "")
    own = [action for group in parser._action_groups[:2] for action in group._group_actions]
    rows = [_option(action) for action in own if not isinstance(action, argparse._HelpAction)]
    if rows:
        yield from table(("argument", ""), _anchored(command.name, rows))
    for title, options in _groups(parser):
        if (title, options) not in shared:
            yield from table((title, ""), _anchored(command.name, options))
    names = [f"[{shared[group].lower()}](#{anchor(shared[group])})" for group in _groups(parser) if group in shared]
    if names:
        joined = " and ".join([*([", ".join(names[:-1])] if names[1:] else []), names[-1]])
        yield from (f"Also the options of {joined}.", "")


def _anchored(owner: str, options: Iterable[tuple[str, str]]) -> Options:
    """Return rows of options that links can lead to: ``cli.md#render-camera`` for ``--camera`` of ``render``."""
    return tuple(
        (f'<a id="{anchor(owner)}-{match[1]}"></a>{shown}' if (match := _LONG.search(shown)) else shown, text)
        for shown, text in options
    )


def _usage(parser: argparse.ArgumentParser) -> str:
    required = "".join(f" {_flag(a)}" for a in parser._actions if a.option_strings and a.required)
    places = "".join(f" {_place(action)}" for action in parser._actions if not action.option_strings)
    return f"{places}{required} [OPTION ...]"


def _place(action: argparse.Action) -> str:
    name = _metavar(action)
    return {"+": f"{name} ...", "*": f"[{name} ...]", "?": f"[{name}]"}.get(str(action.nargs), name)


def _option(action: argparse.Action) -> tuple[str, str]:
    """How an argument is written, and its help."""
    shown = _flag(action) if action.option_strings else _place(action)
    text = (action.help or "").replace("%(default)s", str(action.default)).replace("%%", "%")
    return f"`{shown}`", text.replace("<", "&lt;")


def _flag(action: argparse.Action) -> str:
    value = "" if action.nargs == 0 else f" {_metavar(action)}"
    return ", ".join(f"{name}" for name in action.option_strings) + value


def _metavar(action: argparse.Action) -> str:
    if isinstance(action.metavar, tuple):
        return " ".join(action.metavar)
    if action.metavar is None and action.choices is not None:
        return "|".join(str(choice) for choice in action.choices)
    return action.metavar or action.dest.upper()


def _sentence(command: Command) -> str:
    text = command.brief or command.parser.description or ""
    return _full_stop(text[:1].upper() + text[1:]).replace("<", "&lt;")


def _full_stop(text: str) -> str:
    return text if not text or text.endswith(".") else f"{text}."
