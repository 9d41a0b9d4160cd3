"""Commands about scenes: tree, count, bounds, render, view, export. Without a form they take the value of the
last input if that is a scene, else the root, and say which."""

from __future__ import annotations

import re
import tempfile
from pathlib import Path

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.entity import Scene, count_words
from scenelang.repl.commands import Command, table, unquoted, wanted
from scenelang.repl.display import clean
from scenelang.repl.loop import Repl

_WIDTH, _HEIGHT = 640, 480
_ROWS_OF_IMAGE = 20
_OUTPUT = re.compile(r"""(?:^|\s)-o\s+("[^"]*"|\S+)\s*$""")


def _scene(repl: Repl, form: str) -> Scene:
    """The scene that a command is about; which one is said where the command does not."""
    subject = repl.evaluation.subject_of(form)
    if subject.what is not None:
        repl.screen.write(clean(f"of {subject.what}:"))
    return subject.scene


def _tree(repl: Repl, rest: str) -> None:
    from scenelang.interpreter.outline import outline

    scene = _scene(repl, rest)
    repl.screen.rows(outline(scene))


def _count(repl: Repl, rest: str) -> None:
    scene = _scene(repl, rest)
    counts = count_words(scene.root)
    across = max((len(f"{n:,}") for n in counts.values()), default=0)
    if scene.animated:
        repl.screen.write(f"frame 0 of {len(scene.frames):,}:")
    repl.screen.rows([f"{n:{across},}  {word}" for word, n in counts.items()])


def _bounds(repl: Repl, rest: str) -> None:
    from scenelang.interpreter.selection import word_box

    box = word_box(_scene(repl, rest), None)
    if box is None:
        raise SceneError("empty-scene", "the scene has no geometry, so it has no bounding box")
    low, high = box[:3], box[3:]
    facts = {
        "min": low,
        "max": high,
        "center": [(a + b) / 2 for a, b in zip(low, high)],
        "sizes": [b - a for a, b in zip(low, high)],
    }
    rows = [(name, "[" + " ".join(map(_number, values)) + "]") for name, values in facts.items()]
    repl.screen.rows(table(rows))


def _number(x: float) -> str:
    return f"{round(x, 12) + 0.0:.6g}"  # no rounding errors, no negative zero


# --- pictures and files --------------------------------------------------------------------------------------------


def _render(repl: Repl, rest: str) -> None:
    form, output = _output_of(rest)
    path = Path(output) if output else _next_picture(repl)
    _check_picture(path)
    scene = _scene(repl, form)
    _draw(repl, scene, path)
    if repl.screen.images is not None and path.suffix.lower() in (".png", ".jpg", ".jpeg", ".webp"):
        from scenelang.repl.images import inline

        rows = max(4, min(_ROWS_OF_IMAGE, repl.screen.height - 6))
        repl.screen.write(inline(path, repl.screen.images, rows))
    repl.screen.write(f"wrote {path}")


def _output_of(rest: str) -> tuple[str, str]:
    """The form and the file of ``FORM -o FILE``."""
    match = _OUTPUT.search(rest)
    return (rest[: match.start()].strip(), unquoted(match[1])) if match else (rest, "")


def _next_picture(repl: Repl) -> Path:
    if repl.pictures is None:
        repl.pictures = Path(tempfile.mkdtemp(prefix="scenelang-"))
    return repl.pictures / f"render-{len(list(repl.pictures.iterdir())) + 1}.png"


def _check_picture(path: Path) -> None:
    from scenelang.backends.picture import STILL_ENDINGS

    if path.suffix.lower() not in STILL_ENDINGS:
        hint = f"it can be one of {' '.join(sorted(STILL_ENDINGS))}; films are made with `scenelang render`"
        raise SceneError("backend", f"no picture can be written to `{path.name}`", hint)
    _check_folder(path)


def _check_folder(path: Path) -> None:
    if not path.parent.is_dir():
        raise SceneError("file", f"cannot write {path}: there is no folder {path.parent}")
    if path.is_dir():
        raise SceneError("file", f"cannot write {path}: it is a folder")


def _draw(repl: Repl, scene: Scene, path: Path) -> None:
    from scenelang.backends.picture import PictureOptions, draw, picture_backend, save_image

    options = PictureOptions(
        limit=repl.evaluation.limits.primitives,
        warn=lambda diagnostic: repl.screen.report([diagnostic]),
        width=_WIDTH,
        height=_HEIGHT,
        seed=repl.evaluation.seed,
    )
    save_image(draw(scene, options, picture_backend("draft")), path)


def _export(repl: Repl, rest: str) -> None:
    from scenelang.backends import base

    path = Path(unquoted(wanted(rest, "export", "a file, such as scene.glb")))
    backend = base.for_file(path, base.Work.EXPORT)
    _check_folder(path)
    scene = _scene(repl, "")
    limit = repl.evaluation.limits.primitives
    options = base.Options(limit=limit, warn=lambda diagnostic: repl.screen.report([diagnostic]))
    for written in backend.run(scene, path, options) or [path]:
        repl.screen.write(f"wrote {written}")


def _view(repl: Repl, rest: str) -> None:
    from scenelang.repl.live_view import LiveView

    if repl.live_view is None:
        repl.live_view = LiveView(repl.evaluation)
    repl.screen.write(f"{repl.live_view.address} shows the root and follows the session")
    repl.live_view.open_browser()


COMMANDS = (
    Command("tree", ",tree [FORM]", "the hierarchy of entities", _tree, "FORM"),
    Command("count", ",count [FORM]", "how many of each word there are", _count, "FORM"),
    Command("bounds", ",bounds [FORM]", "the exact bounding box", _bounds, "FORM"),
    Command("render", ",render [FORM] [-o FILE]", "a draft picture, shown in terminals that can", _render, "FORM"),
    Command("view", ",view", "the live viewer in a browser", _view),
    Command("export", ",export FILE", "write the scene for other programs, by the file's ending", _export, "FILE"),
)
