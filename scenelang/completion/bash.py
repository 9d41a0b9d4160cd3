"""The script for bash."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from shlex import quote

from scenelang.completion.model import Argument, Command, Values

_SCRIPT = r"""# Completion of scenelang for bash:  eval "$(scenelang completion bash)"

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


def bash_script(commands: Sequence[Command]) -> str:
    """The script that completes ``commands``."""
    parts = {
        "OPTIONS": [f"    {c.name}) options={quote(' '.join(_flags(c)))} ;;" for c in commands],
        "VALUES": [line for c in commands for line in _value_lines(c)],
        "TAKING": [line for c in commands for line in _taking(c)],
        "COMMANDS": [" ".join(c.name for c in commands)],
        "PLACES": [line for c in commands for line in _place_lines(c)],
    }
    script = _SCRIPT
    for name, lines in parts.items():
        script = script.replace(f"@{name}@", "\n".join(lines))
    return script


def _flags(command: Command) -> list[str]:
    return [flag for option in command.options for flag in option.flags]


def _pattern(command: Command, option: Argument) -> str:
    return "|".join(quote(f"{command.name} {flag}") for flag in option.flags)


def _value_lines(command: Command) -> Iterator[str]:
    for option in command.options:
        if option.values is not Values.NONE:
            yield f"    {_pattern(command, option)}) {_action(option)}return ;;"


def _taking(command: Command) -> Iterator[str]:
    """Options whose value is no positional argument."""
    for option in command.options:
        if option.values is not Values.NONE:
            yield f"      {_pattern(command, option)}) ((i++)) ;;"


def _place_lines(command: Command) -> Iterator[str]:
    if not command.positionals:
        return
    yield f"    {command.name})"
    yield '      case "$place" in'
    for place, argument in enumerate(command.positionals):
        pattern = "*" if argument.repeats else str(place)
        yield f"        {pattern}) {_action(argument)};;"
    yield "      esac ;;"


def _action(argument: Argument) -> str:
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
