"""The script for fish."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from scenelang.completion.model import Argument, Command, Values

_SCRIPT = r"""# Completion of scenelang for fish:  scenelang completion fish > ~/.config/fish/completions/scenelang.fish

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


def fish_script(commands: Sequence[Command]) -> str:
    """The script that completes ``commands``."""
    taking = [
        _quoted(f"{command.name} {flag}")
        for command in commands
        for option in command.options
        if option.values is not Values.NONE
        for flag in option.flags
    ]
    lines = "\n".join(line for command in commands for line in _lines(command))
    return _SCRIPT.replace("@TAKING@", " ".join(taking)).replace("@LINES@", lines)


def _lines(command: Command) -> Iterator[str]:
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
