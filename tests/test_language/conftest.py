"""What the tests of the language share: the value of an expression as it prints, the error of a program, its log."""

from __future__ import annotations

from typing import Any

from scenelang.grammar.datum import Source
from scenelang.grammar.diagnostics import Diagnostic, render_text
from scenelang.interpreter.scene.entity import Scene
from scenelang.session.session import Evaluated, Options, Session

DOT = '\n(bind "dot" (lambda () (call "cube")))\n(scene "dot")\n'
SESSION = Session()


def run(text: str, **options: Any) -> Evaluated:
    """Evaluate a program; a program without words gets one."""
    session = Session(Options(**options)) if options else SESSION
    return session.evaluate(Source("<test>", text if "(bind" in text else text + DOT))


def log(text: str, **options: Any) -> list[str]:
    """What a program that is right prints."""
    result = run(text, **options)
    assert result.ok, "\n".join(render_text(d) for d in result.diagnostics)
    return list(result.log)


def shown(expression: str, definitions: str = "", **options: Any) -> str:
    """The value of an expression as the language prints it."""
    (line,) = log(f"{definitions}\n(print (list {expression}))", **options)
    return line[1:-1]


def error(text: str, **options: Any) -> Diagnostic:
    """The only error of a program."""
    found = [d for d in run(text, **options).diagnostics if d.is_error]
    assert len(found) == 1, [render_text(d) for d in found]
    return found[0]


def refused(text: str, **options: Any) -> str:
    """The name of the only error of a program."""
    return error(text, **options).name


def warned(text: str, **options: Any) -> list[str]:
    """The names of a program's warnings."""
    return [d.name for d in run(text, **options).diagnostics if not d.is_error]


def scene(text: str, **options: Any) -> Scene:
    """The scene of a program that is right."""
    result = run(text, **options)
    assert result.scene is not None, "\n".join(render_text(d) for d in result.diagnostics)
    return result.scene
