"""The script for zsh."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from shlex import quote

from scenelang.completion.model import Argument, Command, Values

_SCRIPT = r"""#compdef scenelang scene
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


def zsh_script(commands: Sequence[Command]) -> str:
    """The script that completes ``commands``."""
    described = "\n".join(f"    {quote(f'{c.name}:{c.help}')}" for c in commands)
    cases = "\n".join(line for c in commands for line in _case(c))
    return _SCRIPT.replace("@COMMANDS@", described).replace("@CASES@", cases)


def _case(command: Command) -> Iterator[str]:
    yield f"    {command.name})"
    yield "      _arguments \\"
    for option in command.options:
        yield f"        {_option(option)} \\"
    for place, argument in enumerate(command.positionals, 1):
        where = "*" if argument.repeats else str(place)
        yield f"        {quote(f'{where}:{_plain(argument.label)}:{_action(argument)}')} \\"
    yield "        ;;"


def _option(option: Argument) -> str:
    """A specification of ``_arguments``: one for all flags of an option, which exclude one another."""
    value = "" if option.values is Values.NONE else f":{_plain(option.label)}:{_action(option)}"
    text = quote(f"[{_bracketed(option.help)}]{value}")
    if len(option.flags) == 1:
        return quote(option.flags[0]) + text
    return quote(f"({' '.join(option.flags)})") + "{" + ",".join(option.flags) + "}" + text


def _action(argument: Argument) -> str:
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
