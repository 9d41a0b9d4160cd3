"""The REPL's commands: a line that begins with a comma, such as ``,doc grid``. Their table, and how one is found."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

from scenelang.grammar.diagnostics import SceneError, suggest

if TYPE_CHECKING:
    from scenelang.repl.loop import Repl


@dataclass(frozen=True, slots=True)
class Command:
    """``operand`` says what stands after the name, for help and completion: "", FORM, NAME, WORD, TEXT, FILE, N."""

    name: str
    usage: str
    doc: str
    run: Callable[[Repl, str], None]
    operand: str = ""


@cache
def commands() -> tuple[Command, ...]:
    """Every command, in the order of the help."""
    from scenelang.repl import about_commands, file_commands, model_commands, scene_commands

    tables = (about_commands, scene_commands, file_commands, model_commands)
    found = [command for table in tables for command in table.COMMANDS]
    order = _ORDER.split()
    return tuple(sorted(found, key=lambda command: order.index(command.name)))


_ORDER = """help doc apropos source tree count bounds expand time trace load reload watch render view export generate
edit seed transpile reset save quit"""


def is_command(text: str) -> bool:
    """Whether an input is a command rather than a form: a comma means nothing else at the top level."""
    stripped = text.lstrip()
    return stripped.startswith(",") and (stripped[1:2].isalpha() or not stripped[1:].strip())


def find(name: str) -> Command:
    """The command of a name or of an unambiguous beginning. Raises SceneError with a suggestion."""
    known = commands()
    exact = [command for command in known if command.name == name]
    begun = exact or [command for command in known if name and command.name.startswith(name)]
    if len(begun) == 1:
        return begun[0]
    if begun:
        listed = ", ".join(f",{command.name}" for command in begun)
        raise SceneError("value", f"`,{name[:40]}` could be {listed}")
    near = suggest(name, [command.name for command in known])
    hint = near.replace("`", "`,", 1) if near else "`,help` lists the commands"
    raise SceneError("value", f"there is no command `,{name[:40]}`", hint)


def split(text: str) -> tuple[str, str]:
    """The name of a command and what stands after it."""
    name, _, rest = text.strip()[1:].partition(" ")
    name = name.strip()
    return (name[:-1], f"! {rest.strip()}") if name.endswith("!") else (name, rest.strip())


def wanted(rest: str, command: str, what: str) -> str:
    """What stands after a command that needs something there. Raises SceneError."""
    if not rest:
        raise SceneError("value", f"`,{command}` wants {what}")
    return rest


def unquoted(text: str) -> str:
    """A file's name, which may stand in quotes."""
    text = text.strip()
    return text[1:-1] if len(text) > 1 and text[0] == text[-1] == '"' else text


def table(rows: Sequence[tuple[str, str]]) -> list[str]:
    """Two columns."""
    across = max((len(left) for left, _ in rows), default=0)
    return [f"{left.ljust(across)}  {right}".rstrip() for left, right in rows]
