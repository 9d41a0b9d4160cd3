"""Commands that ask a language model: generate, edit. Before their text they take the options of the command line."""

from __future__ import annotations

import argparse
import shlex
from dataclasses import replace
from typing import TYPE_CHECKING, NoReturn

from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.source import Source
from scenelang.repl.commands import Command, wanted
from scenelang.repl.loop import Repl
from scenelang.repl.saving import checked_program

if TYPE_CHECKING:
    from scenelang.inference.inference import Inference, Result

_MOST_CHANGES = 12


class _Parser(argparse.ArgumentParser):
    """Says what is wrong with options as every other mistake is said."""

    def error(self, message: str) -> NoReturn:
        raise SceneError("value", message, f"`,help {self.prog}` says how it is used")


def _arguments(command: str, rest: str, what: str) -> argparse.Namespace:
    """The options of a command and the text behind them. Raises SceneError."""
    from scenelang.cli.generate import add_kind
    from scenelang.cli.model_options import add_model_options

    parser = _Parser(prog=command, add_help=False, allow_abbrev=False)
    if command == "generate":
        add_kind(parser)
    add_model_options(parser)
    parser.add_argument("text", nargs="*")
    arguments = parser.parse_args(_words(wanted(rest, command, what)))
    arguments.command, arguments.task = "repl", " ".join(arguments.text)
    for name in ("resume", "dry_run", "json"):
        if getattr(arguments, name):
            raise SceneError("value", f"`--{name.replace('_', '-')}` is for the command line")
    if not arguments.task:
        raise SceneError("value", f"`,{command}` wants {what}")
    return arguments


def _words(text: str) -> list[str]:
    try:
        return shlex.split(text)
    except ValueError:  # an apostrophe
        return text.split()


def _generate(repl: Repl, rest: str) -> None:
    from scenelang.cli.generate import task_of
    from scenelang.cli.model_options import settings_from
    from scenelang.inference.inference import Inference

    arguments = _arguments("generate", rest, "what the scene shows, such as ,generate a lighthouse")
    task = task_of(arguments)
    inference = Inference(task, settings_from(arguments), repl.evaluation.session.options)
    result = _asked(arguments, inference)
    repl.screen.report(result.best.diagnostics)
    _take_over(repl, arguments.task, result.best.program)


def _edit(repl: Repl, rest: str) -> None:
    from scenelang.cli.model_options import ablation_of, settings_from
    from scenelang.inference.editing import edit_of, edit_task, imported_files
    from scenelang.inference.inference import Inference
    from scenelang.scene_changes import OF_AN_EDIT, change_lines

    arguments = _arguments("edit", rest, "an instruction, such as ,edit make the tower higher")
    evaluation = repl.evaluation
    name = evaluation.file or "<repl>"
    program = checked_program(evaluation.session, evaluation.top, name)
    before = evaluation.root()
    task = edit_task(Source(name, program), before, arguments.task, ablation_of(arguments), arguments.seed)
    imports = imported_files(evaluation.session.check(Source(name, program)).program)
    options = replace(evaluation.session.options, imports=imports)
    inference = Inference(task, settings_from(arguments), options, name)
    result = _asked(arguments, inference)
    done = edit_of("the session", task, before, result.best, evaluation.limits.primitives)
    repl.screen.rows(done.text.splitlines())
    repl.screen.rows(change_lines(done.changes, _MOST_CHANGES, OF_AN_EDIT))
    if repl.screen.ask is not None and not repl.screen.ask("take it over?"):
        return
    evaluation.reset()
    _take_over(repl, arguments.task, result.best.code)


def _asked(arguments: argparse.Namespace, inference: Inference) -> Result:
    """Run to the end, in a run folder as on the command line. Raises SceneError."""
    from scenelang.cli.model_runs import begun, played, recorded

    run = begun(arguments, inference, arguments.task)
    with recorded(arguments, run):
        return played(arguments, inference, run)[1]


def _take_over(repl: Repl, name: str, program: str) -> None:
    """Evaluate what the model wrote as one input."""
    outcome = repl.evaluation.evaluate(Source(f"<{name[:40]}>", program), whole=True)
    repl.show(outcome)
    repl.changed()


COMMANDS = (
    Command(
        "generate", ",generate [OPTIONS] TEXT", "take over a scene that a language model makes; options as of "
        "`scenelang generate`", _generate, "TEXT",
    ),
    Command(
        "edit", ",edit [OPTIONS] INSTRUCTION", "let a language model change what is defined", _edit, "TEXT",
    ),
)  # fmt: skip
