"""Commands about names and forms: help, doc, apropos, source, expand, time, trace, seed, reset, quit."""

from __future__ import annotations

import re

from scenelang.grammar.diagnostics import SceneError, suggest
from scenelang.interpreter.library import Builtin
from scenelang.repl.commands import Command, commands, find, table, wanted
from scenelang.repl.descriptions import description, known_names
from scenelang.repl.display import signature_of
from scenelang.repl.loop import Quit, Repl
from scenelang.repl.saving import comment_of
from scenelang.repl.tracing import function_of

_MOST_FOUND = 40


def _help(repl: Repl, rest: str) -> None:
    chosen = (find(rest.lstrip(",")),) if rest else commands()
    repl.screen.rows(table([(command.usage, command.doc) for command in chosen]))
    if not rest:
        repl.screen.rows(["*1 *2 *3 are the last values, *e is the last error. Ctrl-C stops, Ctrl-D leaves."])


# --- what names are ------------------------------------------------------------------------------------------------


def _doc(repl: Repl, rest: str) -> None:
    name = wanted(rest, "doc", "a name")
    lines = description(repl.evaluation.top, name)
    if not lines:
        known = known_names(repl.evaluation.top)
        raise SceneError("unbound", f"there is nothing known of `{name[:40]}`", suggest(name, known))
    repl.screen.prose(lines)


def _apropos(repl: Repl, rest: str) -> None:
    from scenelang.stdlib.reference import records

    text = wanted(rest, "apropos", "a text to look for").lower()
    own = [(name, "") for name, binding in repl.evaluation.top.names() if not isinstance(binding, Builtin)]
    found = [(name, _kind(repl, name)) for name, _ in own if text in name.lower() and not name.startswith("*")]
    found += [(f'"{w}"', "a word of this session") for w in repl.evaluation.top.file.words if text in w.lower()]
    near = [record for record in records() if text in record.name.lower()]
    far = [record for record in records() if record not in near and text in record.doc.lower()]
    rows = [*found, *((record.name, record.doc) for record in [*near, *far])]
    if not rows:
        repl.screen.rows([f"nothing holds `{rest[:40]}`"])
        return
    repl.screen.rows(table(rows[:_MOST_FOUND]))
    if len(rows) > _MOST_FOUND:
        repl.screen.rows([f"... {len(rows) - _MOST_FOUND} more"])


def _kind(repl: Repl, name: str) -> str:
    function = function_of(repl.evaluation.top, name)
    return signature_of(function) if function is not None else "of this session"


def _source(repl: Repl, rest: str) -> None:
    name = wanted(rest, "source", "a name or a word")
    top = repl.evaluation.top
    form = top.definition_of(name) or top.definition_of(f'"{name.strip(chr(34))}"')
    if form is not None:
        repl.screen.rows([*comment_of(form), *(line for d in form.datums for line in d.span.text.split("\n"))])
        return
    text = _library_source(repl, name)
    if text is None:
        raise SceneError(
            "unbound", f"there is no definition of `{name[:40]}`", suggest(name, [n for n, _ in top.names()])
        )
    repl.screen.rows(text.split("\n"))


def _library_source(repl: Repl, name: str) -> str | None:
    """A definition of the library that is written in the language."""
    from scenelang.grammar.reader import read
    from scenelang.grammar.source import Source

    library = repl.evaluation.session.library
    start = re.compile(rf"^\(define \(?{re.escape(name)}[\s)]", re.M)
    for module, text in library.modules.items():
        if start.search(text):
            for datum in read(Source(module, text)).forms:
                if start.match(datum.span.text):
                    return datum.span.text
    if name in library.builtins:
        raise SceneError("value", f"`{name}` is built in; `,doc {name}` tells what it does")
    return None


# --- forms ---------------------------------------------------------------------------------------------------------


def _expand(repl: Repl, rest: str) -> None:
    from scenelang.grammar.layout import layout
    from scenelang.interpreter.forms import INDENTS
    from scenelang.interpreter.unparse import unparse

    evaluation = repl.evaluation
    source = evaluation.source(wanted(rest, "expand", "a form"))
    trees = evaluation.run(lambda: evaluation.top.expansion(source))
    text = layout(unparse(trees), indents=INDENTS)
    repl.screen.rows(text.rstrip("\n").split("\n"))


def _time(repl: Repl, rest: str) -> None:
    evaluation = repl.evaluation
    outcome = evaluation.evaluate(evaluation.source(wanted(rest, "time", "a form")))
    repl.show(outcome)
    if outcome.ok:
        repl.screen.write(f"{outcome.seconds:.3f} s, {outcome.steps:,} steps, {outcome.entities:,} entities made")
    repl.changed()


def _trace(repl: Repl, rest: str) -> None:
    evaluation = repl.evaluation
    if not rest:
        repl.screen.rows([f"traced: {name}" for name in sorted(evaluation.tracer.names)] or ["nothing is traced"])
        return
    top, name = evaluation.top, rest
    if function_of(top, name) is None:
        name = f'"{rest.strip(chr(34))}"'
        if function_of(top, name) is None and name not in evaluation.tracer.names:
            known = [*(n for n, _ in top.names()), *top.file.words]
            raise SceneError("unbound", f"`{rest[:40]}` is no function or word of this session", suggest(rest, known))
    traced = evaluation.tracer.toggle(top, name)
    repl.screen.write(f"{name} is {'traced' if traced else 'no longer traced'}")


# --- the session ---------------------------------------------------------------------------------------------------


def _seed(repl: Repl, rest: str) -> None:
    try:
        seed = int(wanted(rest, "seed", "a whole number"))
    except ValueError:
        raise SceneError("value", f"`{rest[:40]}` is no whole number") from None
    repl.evaluation.set_seed(seed)


def _reset(repl: Repl, rest: str) -> None:
    repl.evaluation.reset()
    repl.screen.write("nothing is defined now")


def _quit(repl: Repl, rest: str) -> None:
    raise Quit


COMMANDS = (
    Command("help", ",help [COMMAND]", "the commands", _help, "COMMAND"),
    Command("doc", ",doc NAME", "what a name, word, primitive, `:attribute` or code such as E401 is", _doc, "NAME"),
    Command("apropos", ",apropos TEXT", "names whose name or description holds a text", _apropos, "TEXT"),
    Command("source", ",source NAME", "the text of a definition, of a name or a word", _source, "NAME"),
    Command("expand", ",expand FORM", "a form after macro expansion", _expand, "FORM"),
    Command("time", ",time FORM", "evaluate a form; seconds, steps, entities", _time, "FORM"),
    Command("trace", ",trace [NAME]", "show the calls of a function or word, or no more; alone: what is traced", _trace,
            "NAME"),
    Command("seed", ",seed N", "start the random streams anew", _seed, "N"),
    Command("reset", ",reset", "forget all definitions", _reset),
    Command("quit", ",quit", "leave", _quit),
)  # fmt: skip
