"""What a shell must know of the commands: names, options and what their values are, read off argparse."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from shlex import quote

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
class ShellCommand:
    name: str
    help: str
    options: tuple[Argument, ...]
    positionals: tuple[Argument, ...]


def commands_of(parser: argparse.ArgumentParser, known: Mapping[str, Sequence[str]]) -> tuple[ShellCommand, ...]:
    """Every command of a parser. ``known``: values of options that take any text, by the option's name."""
    found = []
    for name, (child, brief) in subcommands(parser).items():
        arguments = list(_arguments(child, known))
        found.append(
            ShellCommand(
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


# The script for bash.


_BASH = r"""# Completion of scenelang for bash:  eval "$(scenelang completion bash)"

_scenelang_files() {  # the word, then endings; none: any file
  local IFS=$'\n' word=$1 ending
  shift
  compopt -o filenames 2>/dev/null
  COMPREPLY=($(compgen -d -- "$word"))
  [[ $# -eq 0 ]] && COMPREPLY=($(compgen -f -- "$word"))
  for ending in "$@"; do COMPREPLY+=($(compgen -f -X "!*.$ending" -- "$word")); done
}

_scenelang_words() {  # the words that the programs on this command line bind
  local word file
  for file in "${COMP_WORDS[@]}"; do
    [[ $file == *.scene && -f $file ]] || continue
    while IFS= read -r word; do
      [[ $word == "$1"* ]] && COMPREPLY+=("$(printf %q "$word")")
    done < <(sed -n 's/.*(bind[[:space:]]*"\([^"]*\)".*/\1/p' "$file")
  done
}

_scenelang_choices() {  # the word, then what it may be
  local IFS=$'\n' word=$1
  shift
  COMPREPLY=($(compgen -W "$*" -- "$word"))
}

_scenelang() {
  local cur=${COMP_WORDS[COMP_CWORD]} prev=${COMP_WORDS[COMP_CWORD-1]} command="" options="" place=0 i
  COMPREPLY=()
  if [[ $cur == "=" ]]; then cur=""
  elif [[ $prev == "=" ]]; then prev=${COMP_WORDS[COMP_CWORD-2]}
  fi
  for ((i = 1; i < COMP_CWORD; i++)); do
    [[ ${COMP_WORDS[i]} == -?* ]] && continue
    command=${COMP_WORDS[i]}
    break
  done
  case "$command" in
    "") options="--help --version" ;;
@OPTIONS@
  esac
  case "$command $prev" in
@VALUES@
  esac
  if [[ $cur == -* ]]; then
    COMPREPLY=($(compgen -W "$options" -- "$cur"))
    return
  fi
  for ((i++; i < COMP_CWORD; i++)); do
    case "$command ${COMP_WORDS[i]}" in
@TAKING@
      *" "-?*) ;;
      *) ((place++)) ;;
    esac
  done
  case "$command" in
    "") _scenelang_choices "$cur" @COMMANDS@ ;;
@PLACES@
  esac
}

complete -F _scenelang scenelang scene
"""


def bash_script(commands: Sequence[ShellCommand]) -> str:
    """The script that completes ``commands``."""
    parts = {
        "OPTIONS": [f"    {c.name}) options={quote(' '.join(_flags(c)))} ;;" for c in commands],
        "VALUES": [line for c in commands for line in _value_lines(c)],
        "TAKING": [line for c in commands for line in _taking(c)],
        "COMMANDS": [" ".join(c.name for c in commands)],
        "PLACES": [line for c in commands for line in _place_lines(c)],
    }
    script = _BASH
    for name, lines in parts.items():
        script = script.replace(f"@{name}@", "\n".join(lines))
    return script


def _flags(command: ShellCommand) -> list[str]:
    return [flag for option in command.options for flag in option.flags]


def _pattern(command: ShellCommand, option: Argument) -> str:
    return "|".join(quote(f"{command.name} {flag}") for flag in option.flags)


def _value_lines(command: ShellCommand) -> Iterator[str]:
    for option in command.options:
        if option.values is not Values.NONE:
            yield f"    {_pattern(command, option)}) {_bash_action(option)}return ;;"


def _taking(command: ShellCommand) -> Iterator[str]:
    """Options whose value is no positional argument."""
    for option in command.options:
        if option.values is not Values.NONE:
            yield f"      {_pattern(command, option)}) ((i++)) ;;"


def _place_lines(command: ShellCommand) -> Iterator[str]:
    if not command.positionals:
        return
    yield f"    {command.name})"
    yield '      case "$place" in'
    for place, argument in enumerate(command.positionals):
        pattern = "*" if argument.repeats else str(place)
        yield f"        {pattern}) {_bash_action(argument)};;"
    yield "      esac ;;"


def _bash_action(argument: Argument) -> str:
    """The commands that fill COMPREPLY, each with `; ` behind it."""
    if argument.values is Values.CHOICES:
        return f'_scenelang_choices "$cur" {" ".join(map(quote, argument.choices))}; '
    if argument.values is Values.FILES:
        return f"{' '.join(['_scenelang_files', chr(34) + '$cur' + chr(34), *argument.endings])}; "
    if argument.values is Values.FOLDERS:
        return 'compopt -o filenames 2>/dev/null; COMPREPLY=($(compgen -d -- "$cur")); '
    if argument.values is Values.WORDS:
        return '_scenelang_words "$cur"; '
    return ""


# The script for fish.


_FISH = r"""# Completion of scenelang for fish:  scenelang completion fish > ~/.config/fish/completions/scenelang.fish

function __scenelang_is  # whether the command on this line is $argv[1], empty for none
    set -l tokens (commandline -opc)
    set -l found ""
    for token in $tokens[2..-1]
        if not string match -q -- '-*' $token
            set found $token
            break
        end
    end
    test "$found" = "$argv[1]"
end

function __scenelang_place  # whether the word begins positional argument $argv[2] of the command $argv[1]
    __scenelang_is $argv[1]; or return 1
    set -l place -1
    set -l value 0
    for token in (commandline -opc)[2..-1]
        if test $value = 1
            set value 0
        else if string match -q -- '-?*' $token
            contains -- "$argv[1] $token" $__scenelang_taking; and set value 1
        else
            set place (math $place + 1)
        end
    end
    test $value = 0; and test "$argv[2]" = "*" -o $place = "$argv[2]"
end

function __scenelang_files  # files with one of the endings $argv, and folders
    for candidate in (__fish_complete_path (commandline -ct))
        set -l path (string split -m1 \t -- $candidate)[1]
        if string match -q -- '*/' $path; or contains -- (string replace -r '.*\.' '' -- $path) $argv
            echo $path
        end
    end
end

function __scenelang_words  # the words that the programs on this command line bind
    for file in (commandline -opc)
        if string match -q -- '*.scene' $file; and test -f $file
            sed -n 's/.*(bind[[:space:]]*"\([^"]*\)".*/\1/p' $file
        end
    end
end

set -g __scenelang_taking @TAKING@

complete -c scenelang -f
complete -c scenelang -n "__scenelang_is ''" -s h -l help -d 'show help'
complete -c scenelang -n "__scenelang_is ''" -l version -d 'show the version'
@LINES@
complete -c scene -w scenelang
"""


def fish_script(commands: Sequence[ShellCommand]) -> str:
    """The script that completes ``commands``."""
    taking = [
        _quoted(f"{command.name} {flag}")
        for command in commands
        for option in command.options
        if option.values is not Values.NONE
        for flag in option.flags
    ]
    lines = "\n".join(line for command in commands for line in _lines(command))
    return _FISH.replace("@TAKING@", " ".join(taking)).replace("@LINES@", lines)


def _lines(command: ShellCommand) -> Iterator[str]:
    start = "complete -c scenelang"
    yield f"""{start} -n "__scenelang_is ''" -a {command.name} -d {_quoted(command.help)}"""
    for option in command.options:
        names = " ".join(f"-l {flag[2:]}" if flag.startswith("--") else f"-s {flag[1:]}" for flag in option.flags)
        value = "" if option.values is Values.NONE else f" {_value(option, '-r')}"
        yield f"{start} -n '__scenelang_is {command.name}' {names}{value} -d {_quoted(option.help)}"
    for place, argument in enumerate(command.positionals):
        where = '"*"' if argument.repeats else str(place)
        if argument.values is not Values.ANY:
            yield f"{start} -n '__scenelang_place {command.name} {where}' {_value(argument, '')}".rstrip()


def _value(argument: Argument, required: str) -> str:
    """What completes the values; ``required`` is put before it where files do not exclude each other."""
    exclusive = "-x" if required else "-f"
    if argument.values is Values.CHOICES:
        return f"{exclusive} -a {_quoted(' '.join(argument.choices))}"
    if argument.values is Values.FILES and argument.endings:
        return f"{exclusive} -a '(__scenelang_files {' '.join(argument.endings)})'"
    if argument.values is Values.FILES:
        return f"{required} -F".strip()
    if argument.values is Values.FOLDERS:
        return f"{exclusive} -a '(__fish_complete_directories (commandline -ct))'"
    return f"{exclusive} -a '(__scenelang_words)'" if argument.values is Values.WORDS else exclusive


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace("'", "\\'")
    return f"'{escaped}'"


# The script for zsh.


_ZSH = r"""#compdef scenelang scene
# Completion of scenelang for zsh: a file `_scenelang` in a folder of $fpath, or  eval "$(scenelang completion zsh)"

_scenelang_words() {  # the words that the programs on this command line bind
  local -a found
  local file
  for file in ${words:#-*}; do
    [[ $file == *.scene && -f $file ]] || continue
    found+=(${(f)"$(sed -n 's/.*(bind[[:space:]]*"\([^"]*\)".*/\1/p' $file)"})
  done
  compadd -- $found
}

_scenelang_commands() {
  local -a commands
  commands=(
@COMMANDS@
  )
  _describe command commands
}

_scenelang() {
  local curcontext=$curcontext state line
  typeset -A opt_args
  _arguments -C '(- *)'{-h,--help}'[show help]' '(- *)--version[show the version]' \
    '1:command:_scenelang_commands' '*:: :->rest'
  [[ $state == rest ]] || return
  case $line[1] in
@CASES@
  esac
}

if [[ $funcstack[1] == _scenelang ]]; then
  _scenelang "$@"
else
  compdef _scenelang scenelang scene
fi
"""


def zsh_script(commands: Sequence[ShellCommand]) -> str:
    """The script that completes ``commands``."""
    described = "\n".join(f"    {quote(f'{c.name}:{c.help}')}" for c in commands)
    cases = "\n".join(line for c in commands for line in _case(c))
    return _ZSH.replace("@COMMANDS@", described).replace("@CASES@", cases)


def _case(command: ShellCommand) -> Iterator[str]:
    yield f"    {command.name})"
    yield "      _arguments \\"
    for option in command.options:
        yield f"        {_option(option)} \\"
    for place, argument in enumerate(command.positionals, 1):
        where = "*" if argument.repeats else str(place)
        yield f"        {quote(f'{where}:{_plain(argument.label)}:{_zsh_action(argument)}')} \\"
    yield "        ;;"


def _option(option: Argument) -> str:
    """A specification of ``_arguments``: one for all flags of an option, which exclude one another."""
    value = "" if option.values is Values.NONE else f":{_plain(option.label)}:{_zsh_action(option)}"
    text = quote(f"[{_bracketed(option.help)}]{value}")
    if len(option.flags) == 1:
        return quote(option.flags[0]) + text
    return quote(f"({' '.join(option.flags)})") + "{" + ",".join(option.flags) + "}" + text


def _zsh_action(argument: Argument) -> str:
    if argument.values is Values.CHOICES:
        return f"({' '.join(argument.choices)})"
    if argument.values is Values.FILES:
        return f'_files -g "*.({"|".join(argument.endings)})"' if argument.endings else "_files"
    if argument.values is Values.FOLDERS:
        return "_files -/"
    return "_scenelang_words" if argument.values is Values.WORDS else " "


def _plain(text: str) -> str:
    return text.replace(":", " ")


def _bracketed(text: str) -> str:
    return text.replace("\\", "\\\\").replace("[", "\\[").replace("]", "\\]").replace(":", "\\:")
