"""Advice on words of a command line that nothing takes: what stands beside them tells what they belong to."""

from __future__ import annotations

import argparse
import os
import re
import shlex
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from scenelang.grammar.diagnostics import printable

_MAX_SHOWN = 60  # characters of an argument
_SEPARATORS = ("x", ",", "=", ":")  # between the parts of a value
_NUMBER = re.compile(r"[-+]?[\d.]+")


class CommandWord(NamedTuple):
    """A word of a command line; ``owner`` is the option that it is a value of, ``flag`` its spelling."""

    text: str
    owner: Any = None
    flag: str = ""


def roles(parser: argparse.ArgumentParser, words: Sequence[str]) -> list[CommandWord]:
    """Return the words of a command line with the options that take them; one after a full option has none."""
    own = _flags(parser)
    result: list[CommandWord] = []
    owner, flag, left = None, "", 0
    for text in words:
        if text.startswith("-") and text != "-" and not _NUMBER.fullmatch(text):
            flag, sign, _ = text.partition("=")
            owner = own.get(flag)
            left = (
                0 if sign or owner is None or owner.nargs == 0 else int(str(owner.nargs or 1).replace("?", "1") == "1")
            )
            result.append(CommandWord(text, owner if sign else None, flag))
        else:
            result.append(CommandWord(text, owner, flag) if left else CommandWord(text))
            left = 0
    return result


def advice(parser: argparse.ArgumentParser, words: Sequence[str], stray: str, writer_of: Callable[..., Any]) -> str:
    """Return the line about a word that nothing takes; ``words`` start with the command."""
    read = roles(parser, words)
    loose = [i for i, word in enumerate(read) if word == CommandWord(stray) and i]
    if not loose:
        return f"unexpected argument `{shown(stray)}`"
    index = loose[-1]
    line = _Line(parser, read, index, _end_of_run(read, index + 1))
    for rule in (line.cut, line.pair, line.more_pairs, line.parts, line.quotes, line.after_flag):
        told = rule()
        if told is not None:
            return told
    return line.alone(writer_of)


def _end_of_run(read: Sequence[CommandWord], start: int) -> int:
    """Return the end of the run of words from ``start`` that no option takes."""
    end = start
    while end < len(read) and read[end] == CommandWord(read[end].text) and not read[end].text.startswith("-"):
        end += 1
    return end


def _flags(parser: argparse.ArgumentParser) -> dict[str, Any]:
    """Return the options of a parser by each of their spellings."""
    return {flag: action for action in parser._actions for flag in action.option_strings}


def of_invalid(parser: argparse.ArgumentParser, words: Sequence[str], message: str) -> str | None:
    """Return the line about the value of an option that cannot be read, if what follows it belongs to it."""
    match = re.match(r"argument ([^\s:]+): ", message)
    if match is None:
        return None
    own = _flags(parser)
    single = next((word for word in words if len(word) > 2 and f"-{word.partition('=')[0]}" in own), None)
    if single is not None and "ignored explicit argument" in message:
        return f"an option has two dashes: `-{shown(single)}`"
    action = own.get(match[1].split("/")[-1])
    if message.endswith("expected one argument") and action is not None:
        value = " or ".join(map(str, action.choices)) if action.choices else action.metavar or "VALUE"
        return f"`{match[1].split('/')[0]}` needs a value: `{match[1].split('/')[0]} {value}`"
    read = roles(parser, words)
    flags = match[1].split("/")
    for index, word in enumerate(read):
        if word.owner is not None and flags[-1] in word.owner.option_strings and index + 1 < len(read):
            end = _end_of_run(read, index + 1)
            line = _Line(parser, read, index + 1, end)
            told = line.cut() or line.parts() if end > index + 1 else None
            if told is not None:
                return told
    return None


def of_choice(parser: argparse.ArgumentParser, message: str) -> str | None:
    """Return the line about a value that is none of the choices of an option: the option, its choices, the value."""
    match = re.match(r"argument ([^\s:]+): invalid choice: (.*) \(choose from ", message)
    if match is None:
        return None
    flags = match[1].split("/")
    for action in parser._actions:
        names = action.option_strings or [str(action.metavar or action.dest)]
        if action.choices and flags[-1] in names:
            from scenelang.grammar.diagnostics import suggest

            choices = [str(choice) for choice in action.choices]
            value = match[2].strip("'\"")
            near = suggest(value, choices)
            listed = " or ".join(filter(None, (", ".join(f"`{c}`" for c in choices[:-1]), f"`{choices[-1]}`")))
            return f"`{flags[-1]}` is {listed}, got `{shown(value)}`{f'; {near}' if near else ''}"
    return None


class _Line:
    """A command line with the run of words from ``start`` to ``end`` that nothing takes."""

    def __init__(self, parser: argparse.ArgumentParser, read: Sequence[CommandWord], start: int, end: int) -> None:
        self.parser, self.read, self.start, self.end = parser, read, start, end
        self.before = read[start - 1]
        self.owner = self.before.owner
        self.texts = [word.text for word in read[start:end]]

    def _value(self) -> str:
        """Return the value of the option before the run."""
        return self.before.text.removeprefix(f"{self.before.flag}=")

    def cut(self) -> str | None:
        """``--camera azimuth=45, elevation=20``: a value that spaces cut at a comma or a sign."""
        first = 0 if self.owner is None else -1
        parts = [self._value(), *self.texts] if first else self.texts
        whole = parts[0]
        for part in parts[1:]:
            if not (whole.endswith((",", "=")) or part.startswith((",", "="))):
                break
            whole += part
        if whole == parts[0]:
            return None
        written = f"{self.before.flag} {whole}" if first else self._for_pair(whole) or whole
        apart = parts[1] if first else parts[0]
        beside = f"`{self.before.flag} {parts[0]}`" if first else f"`{parts[1]}`"
        if parts[1] in ",=" and len(parts) > 2:  # a sign between two parts
            beside, apart = f"`{parts[0]}`", parts[2]
        return f"`{shown(apart)}` stands apart from {beside}: leave out the space: `{shown(written)}`"

    def _for_pair(self, text: str) -> str | None:
        """Return the option that takes ``NAME=VALUE``: one of this name, else `--define`."""
        name, sign, value = text.partition("=")
        own = _flags(self.parser)
        if not sign or not re.fullmatch(r"[\w-]+", name):
            return None
        if own.get(f"--{name}") is not None and own[f"--{name}"].nargs != 0:
            return f"--{name} {value}"
        return f"--define {text}" if "--define" in own else None

    def pair(self) -> str | None:
        """``--define houses 10``: a pair whose sign is missing."""
        metavar = str(getattr(self.owner, "metavar", ""))
        if "=" not in metavar or "=" in self._value():
            return None
        flag = self.before.flag
        written = f"{flag} {self._value()}={shlex.quote(self.texts[0])}"
        return f"`{flag}` takes one argument {metavar}, with `=` inside: `{shown(written)}`"

    def more_pairs(self) -> str | None:
        """``--camera azimuth=45 elevation=20``: pairs that the option takes in one argument."""
        names = [text.partition("=")[0] for text in self.texts if "=" in text]
        if self.owner is None or "=" not in self._value() or len(names) != len(self.texts):
            return None
        if not all(f"{name}=" in str(self.owner.help) for name in names):
            return None
        whole = ",".join([self._value(), *self.texts])
        return f"`{self.before.flag}` takes one argument, with commas: `{self.before.flag} {shown(whole)}`"

    def parts(self) -> str | None:
        """``--size 800 600``: the parts of one value, which the option reads if they are joined."""
        if self.owner is None or self.owner.type is None:
            return None
        for separator in ("", *_SEPARATORS) if len(self.texts) > 1 else _SEPARATORS:
            whole = separator.join([self._value(), *self.texts])
            try:
                self.owner.type(whole)
            except (argparse.ArgumentTypeError, ValueError, TypeError):
                continue
            flag = self.before.flag
            return f"`{flag}` takes one argument, without spaces: `{flag} {shown(whole)}`"
        return None

    def quotes(self) -> str | None:
        """``--word kitchen table`` and ``generate a red chair``: a text whose quotes are missing."""
        if any(os.path.isfile(text) or "=" in text for text in self.texts):
            return self._file_name()
        if self.owner is not None:
            if self.owner.nargs == 0 or self.owner.type is not None or self.owner.choices:
                return None
            what = str(self.owner.metavar or self.before.flag.lstrip("-").upper())
            texts = [self._value(), *self.texts]
            if what.endswith(",..."):
                return f"`{self.before.flag}` takes one argument, with commas: `{self.before.flag} {','.join(texts)}`"
            if all(_NUMBER.fullmatch(text) for text in texts):
                return f"`{self.before.flag}` takes one argument {what}: {_help(self.owner)}"
            if what in _ONE_WORD:
                return None
            if what == "DECLARATION":
                return _declared(self.before.flag, texts)
            return f"{what} is one argument: put it in quotes: `{self.before.flag} {_quoted(texts)}`"
        texts_of = [a for a in self.parser._actions if not a.option_strings and "FILE" not in str(a.metavar)]
        if not texts_of or isinstance(texts_of[-1], argparse._SubParsersAction) or texts_of[-1].metavar in _NO_TEXT:
            return self._file_name()
        first = self.start
        skipped = sum(not action.option_strings for action in self.parser._actions) - 1
        while first > 1 + skipped and self.read[first - 1] == CommandWord(self.read[first - 1].text):
            first -= 1
        run = [word.text for word in self.read[first : self.end]]
        words = [w.text for w in self.read[:first]] + [_quoted(run)] + [w.text for w in self.read[self.end :]]
        name = texts_of[-1].metavar
        return f"{name} is one argument: put it in quotes: `{printable(' '.join(['scenelang', *words]))}`"

    def _file_name(self) -> str | None:
        """``render my chair.scene``: the name of a file with spaces."""
        whole = " ".join([self.before.text, *self.texts])
        if self.start > 1 and os.path.isfile(whole):
            return f"a name with spaces needs quotes: `{_quoted([whole])}`"
        return None

    def after_flag(self) -> str | None:
        """``--json out.json``: a word after an option that takes none."""
        flag = self.before.text
        action = _flags(self.parser).get(flag)
        if action is None or action.nargs != 0:
            return None
        return f"`{flag}` takes no value, got `{shown(self.texts[0])}`"

    def alone(self, writer_of: Callable[[str], str | None]) -> str:
        """Return what a word is by itself: a value of an option that is not named, an output, one more program."""
        text = self.texts[0]
        command = self.read[0].text
        line = f"unexpected argument `{shown(text)}`"
        own = _flags(self.parser)
        pair = self._for_pair(text)
        if pair is not None:
            return f"{line}; did you mean `{shown(pair)}`?"
        if f"--{text}" in own:
            return f"{line}; an option has two dashes: `--{shown(' '.join(self.texts))}`"
        for flag, action in own.items():
            if flag.startswith("--") and _takes(action, text):
                return f"{line}; did you mean `{flag} {shown(text)}`?"
        if "--word" in own and not os.path.isfile(text) and "." not in text:
            return f"{line}; did you mean `--word {_quoted(self.texts) if len(self.texts) > 1 else shown(text)}`?"
        takes_one = any(action.dest == "file" for action in self.parser._actions)
        if not takes_one:
            return line
        line += f"; `{command}` takes one program"
        if os.path.isfile(text):
            return f"{line}: run it once for each"
        writer = writer_of(text)
        if "-o" in own and not any(word.flag in ("-o", "--output") for word in self.read) and "." in text:
            if writer in (None, command) and not os.path.isfile(text):
                return f"{line}; to name the output write `-o {shown(text)}`"
        if writer not in (None, command):
            flag = output_option(writer)
            program = next((word.text for word in self.read[1:] if word.owner is None), "FILE")
            return f"{line}; `scenelang {writer} {shown(program)} {flag} {shown(text)}` writes such a file"
        return line


_ONE_WORD = ("NAME", "LEVEL", "VIEW")  # values without spaces
_NO_TEXT = ("SPEC", "WORD", "CODE", "A", "B", "RUN", "SHELL", "ACTION")


def _takes(action: Any, text: str) -> bool:
    """Return whether an option takes a value, and takes few others: it has choices, or reads pairs of numbers."""
    if action.choices:
        return text in action.choices
    if action.nargs == 0 or action.type is None or _NUMBER.fullmatch(text):
        return False
    try:
        return action.type("?") is None
    except (argparse.ArgumentTypeError, ValueError, TypeError):
        try:
            return action.type(text) is not None
        except (argparse.ArgumentTypeError, ValueError, TypeError):
            return False


def _help(action: Any) -> str:
    """Return the help text of an option."""
    return re.sub(r"\s+", " ", str(action.help or "")).replace("%%", "%")


def _declared(flag: str, texts: Sequence[str]) -> str:
    """Return the line about a declaration of which the parentheses and the quotes are missing."""
    from scenelang.session.declarations import declaration_of_words

    written = declaration_of_words(" ".join(texts)) or '(on "cup" "table")'
    return f"a declaration is one argument, in parentheses and with words in quotes: `{flag} '{shown(written)}'`"


def _quoted(texts: Sequence[str]) -> str:
    """Return words as one argument, in double quotes where the shell leaves those alone."""
    whole = " ".join(texts)
    return shlex.quote(whole) if re.search(r'["$`\\!]', whole) else f'"{whole}"'


def output_option(command: str | None) -> str:
    """Return the option of a command that names its output."""
    return "--html" if command == "view" else "-o"


def shown(text: str) -> str:
    """Return the beginning of an argument as a message shows it."""
    return printable(text)[:_MAX_SHOWN]
