"""Commands about files: load, reload, watch, transpile, save."""

from __future__ import annotations

from pathlib import Path

from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.source import Source
from scenelang.repl.commands import Command, unquoted, wanted
from scenelang.repl.loop import Repl
from scenelang.repl.saving import checked_program


def _load(repl: Repl, rest: str) -> None:
    path = unquoted(wanted(rest, "load", "a file"))
    outcome = repl.evaluation.load(path)
    repl.show(outcome)
    if outcome.ok:
        repl.evaluation.loaded = path
        repl.screen.write(f"loaded {path}")
    repl.changed()


def _reload(repl: Repl, rest: str) -> None:
    path = _file_of(repl, "reload")
    outcome = repl.evaluation.reload(path)
    repl.show(outcome)
    if outcome.ok:
        repl.screen.write(f"loaded {path}")
    repl.changed()


def _file_of(repl: Repl, command: str) -> str:
    path = repl.evaluation.loaded or repl.evaluation.file
    if path is None:
        raise SceneError("value", f"`,{command}` wants a file that was loaded before", "`,load FILE` loads one")
    return path


def _watch(repl: Repl, rest: str) -> None:
    from scenelang.repl.watching import Watch

    if repl.watch is not None:
        repl.watch.stop()
        repl.screen.write(f"{repl.watch.path} is no longer watched")
        repl.watch = None
        if not rest:
            return
    path = unquoted(rest) if rest else _file_of(repl, "watch")
    if path != (repl.evaluation.loaded or repl.evaluation.file):
        _load(repl, path)
        if repl.evaluation.loaded != path:
            return
    repl.watch = Watch(repl, path)
    repl.screen.write(f"{path} is watched; `,watch` ends it")


def _transpile(repl: Repl, rest: str) -> None:
    path = unquoted(wanted(rest, "transpile", "a file with a language model's Python"))
    evaluation = repl.evaluation
    translation = evaluation.session.transpile(evaluation.session.source(path))
    repl.screen.report(translation.diagnostics)
    if not translation.ok:
        repl.errors += 1
        return
    before = len(evaluation.top.forms)
    outcome = evaluation.evaluate(Source(f"<{Path(path).name}>", translation.text), whole=True)
    repl.show(outcome)
    if outcome.ok:
        forms = [form for form in evaluation.top.forms if form.datums[0].span.source.name == f"<{Path(path).name}>"]
        words = sum(len(form.words) for form in forms)
        repl.screen.write(f"{len(forms) or len(evaluation.top.forms) - before} definitions, {words} of them words")
    repl.changed()


def _save(repl: Repl, rest: str) -> None:
    from scenelang.backends.files import written_whole

    is_forced = rest.startswith("!") or rest.endswith(" !")
    name = unquoted(wanted(rest.strip("! "), "save", "a file; `,save! FILE` overwrites"))
    if name == "-":
        raise SceneError("value", "`,save` writes to a file, and `-` names none", "a file of that name is `./-`")
    path = Path(name)
    text = checked_program(repl.evaluation.session, repl.evaluation.top, str(path))
    if path.is_dir() or not path.parent.is_dir():
        why = "it is a folder" if path.is_dir() else f"there is no folder {path.parent}"
        raise SceneError("file", f"cannot write {path}: {why}")
    if path.exists() and not is_forced and not _may_replace(repl, path):
        raise SceneError("file", f"{path} is there already", f"`,save! {path}` overwrites it")
    with written_whole(path) as temporary:
        temporary.write_text(text, "utf-8", newline="\n")
    repl.screen.write(f"wrote {path}")


def _may_replace(repl: Repl, path: Path) -> bool:
    return repl.screen.ask is not None and repl.screen.ask(f"overwrite {path}?")


COMMANDS = (
    Command("load", ",load FILE", "evaluate a file", _load, "FILE"),
    Command("reload", ",reload", "evaluate the file again", _reload),
    Command("watch", ",watch [FILE]", "evaluate a file when it changes, say what changed; again: end", _watch, "FILE"),
    Command("transpile", ",transpile FILE", "take over what a language model's Python defines", _transpile, "FILE"),
    Command("save", ",save FILE", "write the definitions as a program; `,save! FILE` overwrites", _save, "FILE"),
)
