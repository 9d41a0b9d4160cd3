"""Advice on wrong command lines: a command that is missing, options of other commands and of other tools."""

from __future__ import annotations

import argparse
import os
import re
import shlex
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any

from scenelang.cli import stray_words
from scenelang.cli.command_table import COMMANDS
from scenelang.cli.stray_words import output_option, shown
from scenelang.grammar.diagnostics import is_one_letter_off, near_names, printable

_MIN_STEM = 4  # letters of an option that another one contains
_HELP = ("-h", "--help", "--version")

Build = Callable[[str], argparse.ArgumentParser]


def missing_command(words: Sequence[str]) -> str | None:
    """Return the line about words without a command, such as ``-o chair.stl chair.scene``, or None."""
    first = words[0]
    if f"--{first}" in _HELP and first not in COMMANDS:
        command = f"{words[1]} " if len(words) > 1 and words[1] in COMMANDS else ""
        return f"unknown command `{first}`; it is an option: `scenelang {command}--{first}`"
    is_option = first.startswith("-") and first not in _HELP
    is_file = first not in COMMANDS and (first.endswith(".scene") or os.path.isfile(first))
    if not (is_option or is_file):
        return None
    outputs = [after for flag, after in pairwise(words) if flag in ("-o", "--output")]
    programs = [word for word in words if word not in outputs and not word.startswith("-") and "." in word]
    program = next((word for word in programs if word.endswith(".scene")), programs[0] if programs else "FILE")
    written = f" -o {outputs[0]}" if outputs else ""
    writer = writer_of(outputs[0]) if outputs else "run"
    line = f"a command is missing before `{shown(first)}`"
    later = next((word for word in words[1:] if word in COMMANDS and word not in outputs), None)
    if later is not None:
        rest = shown(" ".join(word for word in words if word is not later))
        return f"the command comes first: `scenelang {later} {rest}`"
    if not outputs and not is_option and first.endswith(".scene"):
        ways = f"`scenelang render {shown(first)}` draws it, `view` shows it, `run` summarizes it"
        return f"`{shown(first)}` is a program, and the command before it is missing: {ways}"
    if writer is None:
        return f"{line}; see `scenelang --help` for a list of commands"
    return f"{line}: `scenelang {writer} {shown(program)}{shown(written)}`"


def whole_command(words: Sequence[str]) -> str | None:
    """Return the command line that an unknown command with a program and an output means, else None."""
    files = [word for word in words[1:] if not word.startswith("-")]
    if len(files) != 2 or not files[0].endswith(".scene"):
        return None
    writer = writer_of(files[1]) if not files[1].endswith(".scene") else None
    option = output_option(writer)
    return f"write `scenelang {writer} {printable(files[0])} {option} {printable(files[1])}`" if writer else None


def writer_of(output: str) -> str | None:
    """Return the command that writes files with the ending of ``output``, or None."""
    from scenelang.backends import base

    ending = os.path.splitext(output)[1].lower()
    for work in base.Work:
        if any(ending in backend.endings for backend in base.all_backends(work)):
            return str(work.value)
    return "view" if ending in (".html", ".htm") else None


def other_command(command: str, program: str, output: str) -> str | None:
    """Return the hint for an output that another command writes, or None."""
    other = writer_of(output)
    near = _near_output(command, output) if other is None else None
    if near is not None:
        return near
    if other is None and command == "export":
        return f"most tools read {os.path.splitext(output)[0]}.glb; `scenelang backends` lists all formats"
    if other is None or other == command:
        return None
    return f"`scenelang {other} {program} {output_option(other)} {output}` does"


_MAX_READ = 100_000  # characters of a program that are searched for its params
_MIN_SHARED = 4  # letters that two endings begin with


def _near_output(command: str, output: str) -> str | None:
    """Return the hint for an ending that is spelled like one that a command writes, or begins with it."""
    from scenelang.backends import base

    stem, ending = os.path.splitext(output)
    kind = ending.lower().lstrip(".")
    works = [work for work in base.Work if work.value == command]
    kinds = [e.lstrip(".") for work in works for backend in base.all_backends(work) for e in backend.endings]
    longer = [known for known in kinds if len(known) >= _MIN_SHARED and kind.startswith(known)]
    near = longer or [known for known in kinds if is_one_letter_off(kind, known)] if len(kind) > 1 else []
    if not near:
        return None
    others = ", ".join(f".{known}" for known in dict.fromkeys(kinds) if known != near[0])
    written = f"write `-o {stem}.{near[0]}`" if longer else f"did you mean `-o {stem}.{near[0]}`?"
    return f"{written}{';' if longer else ''} it also writes {others}"


class Adviser:
    """Advice of the parser of one command; ``build`` makes the parser of another one."""

    def __init__(self, command: str, parser: argparse.ArgumentParser, words: Sequence[str], build: Build) -> None:
        self._command, self._parser, self._words, self._build = command, parser, words, build

    def __call__(self, unknown: Sequence[str], message: str) -> str | None:
        """Return the line about unknown arguments, or about a message of argparse; None if it needs no other words."""
        if not unknown:
            told = stray_words.of_choice(self._parser, message)
            told = told or stray_words.of_invalid(self._parser, self._words, message)
            return told or self._missing_file(message)
        option, sign, value = unknown[0].partition("=")
        if not option.startswith("-"):
            return stray_words.advice(self._parser, self._words, unknown[0], writer_of)
        following = [word for word in unknown[1:2] if not word.startswith("-")]
        value = value if sign else "".join(following)
        line = f"`{self._command}` has no option `{shown(option)}`"
        own = dict(_options(self._parser))
        owners = self._owners(option)
        others = {name: action for name, action in owners.items() if option in dict(_options(self._build(name)))}
        output = self._output(option.lstrip("-"), value, own)
        if output is not None:
            return f"{line}; the format follows the ending of the output: `{output}`"
        param = self._param(option.lstrip("-"), value, own)
        if param is not None:
            return f"{line}; did you mean `{param}`?"
        prints = COMMANDS[self._command].kind.evaluates
        if option in ("-o", "--output") and prints and not _for_file(own, value):
            command = f"scenelang {' '.join(self._words[: self._words.index(unknown[0])])}"
            return f"{line}; it prints: `{printable(command)} > {shown(value or 'FILE')}`"
        meant = _for_file(own, value) or _meant(option, own, next(iter(others.values()), None))
        if others:
            line += f", which is an option of {_listed(list(others))}"
        if meant is not None:
            return f"{line}; did you mean `{_written(meant, own[meant], value)}`?"
        return line

    def _output(self, name: str, value: str, own: Mapping[str, Any]) -> str | None:
        """Return the option that names an output of the kind that an unknown option, or its value, is called by."""
        if "--output" not in own:
            return None
        program = next((word for word in self._words[1:] if word.endswith(".scene")), "scene")
        outputs = [after for flag, after in pairwise(self._words) if flag in ("-o", "--output")]
        stem = os.path.splitext(os.path.basename(outputs[0] if outputs else program))[0]
        for kind in (value, name):
            ending = f".{kind.lower().lstrip('.')}"
            if kind and "." not in ending[1:] and writer_of(f"{stem}{ending}") == self._command:
                return f"-o {shown(stem + ending)}"
        return None

    def _param(self, name: str, value: str, own: Mapping[str, Any]) -> str | None:
        """Return the `--define` of a param of the program that an unknown option is named after, or of its value."""
        if "--define" not in own:
            return None
        if re.fullmatch(r"[\w-]+=\S+", value) and len(name) == 1:
            return f"--define {value}"
        for word in self._words[1:]:
            if word.endswith(".scene") and os.path.isfile(word):
                with open(word, encoding="utf-8", errors="replace") as file:
                    if re.search(rf"\(param {re.escape(name)}\s", file.read(_MAX_READ)):
                        return f"--define {name}={value or 'VALUE'}"
        return None

    def _owners(self, option: str) -> Mapping[str, Any]:
        """Return the commands that have an option, with its action."""
        actions: dict[str, Any] = {}
        for name in COMMANDS:
            if name != self._command:
                try:
                    action = dict(_options(self._build(name))).get(option)
                except ImportError:
                    continue
                if action is not None:
                    actions[name] = action
        return actions

    def _missing_file(self, message: str) -> str | None:
        """Return the line about a missing program, with `-` if the command reads standard input."""
        match = re.fullmatch(r"the following arguments are required: (.*)", message)
        if match is None:
            return None
        reads_input = any(
            action.metavar == "FILE" and "standard input" in str(action.help) for action in self._parser._actions
        )
        if "FILE" not in match[1].split(", ") or not reads_input:
            return self._missing_arguments(match[1].split(", "))
        rest = " ".join(self._words[1:])
        command = printable(f"scenelang {self._command} - {rest}".rstrip())
        return f"{match[1]} is missing: name a program, or read standard input by `{command}`"

    def _missing_arguments(self, names: Sequence[str]) -> str:
        """Return the line about arguments that are missing, with the command line that has them."""
        written = []
        own = dict(_options(self._parser))
        unknown = [word for word in self._words if word.startswith("--") and word.partition("=")[0] not in own]
        meant = {_meant(word, own, None): word for word in reversed(unknown)}
        for action in self._parser._actions:
            flags = action.option_strings
            near = next((flag for flag in flags if flag in meant and "/".join(flags) in names), None)
            if near is not None:
                return f"`{self._command}` has no option `{shown(meant[near])}`; did you mean `{near}`?"
            if "/".join(flags) in names or (not flags and (action.metavar or action.dest) in names):
                metavar = action.metavar if isinstance(action.metavar, str) else action.dest
                written.append(f"{flags[0]} {metavar}" if flags else metavar)
        verb = "is" if len(names) == 1 else "are"
        texts = [word for word in self._words[1:] if " " in word]
        if texts and "--prompt" in own and "--prompt" not in self._words:
            words = [word for word in self._words if word not in texts]
            command = printable(shlex.join(["scenelang", *words, "--prompt", texts[0]]))
            return f"a text follows `--prompt`: `{command} ...`"
        command = printable(f"scenelang {shlex.join(self._words)} {' '.join(written)}")
        return f"{', '.join(names)} {verb} missing: `{command}`"


def _for_file(own: Mapping[str, Any], value: str) -> str | None:
    """Return the option that takes files with the ending of a value, such as ``--html OUT.html``."""
    ending = os.path.splitext(value)[1].lower()
    return next((flag for flag, action in own.items() if ending and str(action.metavar).endswith(ending)), None)


def _options(parser: argparse.ArgumentParser) -> Iterator[tuple[str, Any]]:
    """Iterate over the long options of a parser, or of the parser of its only command, with their actions."""
    commands = next((a for a in parser._actions if isinstance(a, argparse._SubParsersAction)), None)
    if commands is not None and len(commands.choices) == 1:
        (parser,) = commands.choices.values()
    for action in parser._actions:
        yield from ((flag, action) for flag in action.option_strings if flag.startswith("--"))


def _listed(names: Sequence[str]) -> str:
    """Return the first commands of a list."""
    return ", ".join(f"`{name}`" for name in names[:3]) + (" and others" if len(names) > 3 else "")


_OF_IMAGES = ("width", "height", "res", "resolution")  # names of other programs for the size of an image


def _meant(option: str, own: Mapping[str, Any], other: Any) -> str | None:
    """Return the option of a command that an unknown one probably means.

    It is described in the same terms as the option of this name of another command, ``other``. Without one, it is part
    of the unknown name or contains it, is described by its word, or is spelled like it.
    """
    if other is not None:
        codes = _codes(other)
        alike = next((flag for flag, action in own.items() if codes & _codes(action)), None)
        return alike or _described(option, own)
    stem = option.lstrip("-")
    if stem in _OF_IMAGES and "--size" in own:
        return "--size"
    contained = [flag for flag in own if len(flag[2:]) >= _MIN_STEM and flag[2:] in stem]
    containing = [flag for flag in own if len(stem) >= _MIN_STEM and stem in flag[2:]]
    if contained or containing:
        return max(contained, key=len, default="") or min(containing, key=len)
    near = near_names(option, own)
    return _described(option, own) or (near[0] if near else None)


def _described(option: str, own: Mapping[str, Any]) -> str | None:
    """Return the only option whose help text has the word of an unknown one."""
    stem = option.lstrip("-")
    word = re.compile(rf"\b{re.escape(stem.rstrip('s'))}\b")
    described = [flag for flag, action in own.items() if word.search(_help(action))]
    return described[0] if len(described) == 1 and len(stem) >= _MIN_STEM else None


def _codes(action: Any) -> set[str]:
    """Return the code in the help text of an option, such as an example."""
    return set(re.findall(r"`([^`]+)`", _help(action)))


def _help(action: Any) -> str:
    """Return the help text of an option."""
    return str(action.help or "")


def _written(flag: str, action: Any, value: str) -> str:
    """Return an option with the value that was given, if it accepts that, else with what it takes."""
    if action.nargs == 0:
        return flag
    for text in (value, value.replace(",", "x")):
        try:
            if text and (action.type is None or action.type(text) is not None):
                return f"{flag} {shown(text)}"
        except (argparse.ArgumentTypeError, ValueError, TypeError):
            continue
    return f"{flag} {action.metavar}" if isinstance(action.metavar, str) else flag
