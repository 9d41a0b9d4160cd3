"""The page of the command line, from the parser that the commands use."""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence

from generator.markdown import NOTICE, anchor, table
from scenelang.cli.backend_options import add_now
from scenelang.cli.main import build_parser

Options = tuple[tuple[str, str], ...]


def cli_page() -> str:
    """Every command with its options, Markdown."""
    commands = dict(_commands(build_parser(), ()))
    shared = _shared(commands)
    lines = [
        "# The command line",
        "",
        NOTICE,
        "",
        "`scenelang COMMAND ...`, short `scene COMMAND ...`. The exit code is 0 on success, 1 for a wrong program or file,",
        "2 for wrong usage, 130 after an interruption.",
        "",
    ]
    lines += table(
        ("command", ""),
        [(f"[`{name}`](#{anchor(name)})", _sentence(parser, brief)) for name, (parser, brief) in commands.items()],
    )
    for name, (parser, brief) in commands.items():
        lines += _command(name, parser, brief, shared)
    lines += ["## Options that commands share", ""]
    for (title, options), heading in shared.items():
        lines += [f"### {heading}", "", *table((title, ""), options)]
    return "\n".join(lines).rstrip("\n") + "\n"


def _commands(
    parser: argparse.ArgumentParser, path: tuple[str, ...]
) -> Iterator[tuple[str, tuple[argparse.ArgumentParser, str]]]:
    """Every command that has no commands of its own, by its whole name, with its line of help."""
    for action in parser._actions:
        if not isinstance(action, argparse._SubParsersAction):
            continue
        briefs = {choice.dest: choice.help or "" for choice in action._choices_actions}
        for name, child in action.choices.items():
            add_now(child)
            inner = list(_commands(child, (*path, name)))
            yield from inner or [(" ".join((*path, name)), (child, briefs.get(name, "")))]


def _groups(parser: argparse.ArgumentParser) -> Iterator[tuple[str, Options]]:
    """The named groups of options of a command."""
    for group in parser._action_groups[2:]:
        options = tuple(_option(action) for action in group._group_actions)
        if options:
            yield group.title or "", options


def _shared(
    commands: Mapping[str, tuple[argparse.ArgumentParser, str]],
) -> Mapping[tuple[str, Options], str]:
    """Groups that several commands have, with their headings."""
    count = Counter(group for parser, _ in commands.values() for group in _groups(parser))
    found = [group for group, times in count.items() if times > 1]
    same = Counter(title for title, _ in found)
    numbers: Counter[str] = Counter()
    headings = {}
    for title, options in found:
        numbers[title] += 1
        headings[title, options] = title.capitalize() + (f" {numbers[title]}" if same[title] > 1 else "")
    return headings


def _command(
    name: str, parser: argparse.ArgumentParser, brief: str, shared: Mapping[tuple[str, Options], str]
) -> Iterator[str]:
    yield from (f"## {name}", "", f"`scenelang {name}{_usage(parser)}`", "", _sentence(parser, brief), "")
    if parser.description:
        yield from (_full_stop(parser.description), "")
    own = [action for group in parser._action_groups[:2] for action in group._group_actions]
    rows = [_option(action) for action in own if not isinstance(action, argparse._HelpAction)]
    if rows:
        yield from table(("argument", ""), rows)
    for title, options in _groups(parser):
        if (title, options) not in shared:
            yield from table((title, ""), options)
    names = [f"[{shared[group].lower()}](#{anchor(shared[group])})" for group in _groups(parser) if group in shared]
    if names:
        yield from (f"Also the options of {' and '.join([*([', '.join(names[:-1])] if names[1:] else []), names[-1]])}.", "")


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


def _sentence(parser: argparse.ArgumentParser, brief: str) -> str:
    text = brief or parser.description or ""
    return _full_stop(text[:1].upper() + text[1:]).replace("<", "&lt;")


def _full_stop(text: str) -> str:
    return text if not text or text.endswith(".") else f"{text}."
