"""Cell magic ``%%scene`` for Jupyter and IPython, registered by ``%load_ext scenelang`` (docs/python.md)."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from importlib.util import find_spec
from keyword import iskeyword
from typing import TYPE_CHECKING, Any, TypeVar

from scenelang.backends.pictures.declared import view_of
from scenelang.backends.pictures.images import View, image_of, picture_options
from scenelang.backends.viewer.packet import ViewerPage, page_of
from scenelang.grammar.datum import Source
from scenelang.grammar.diagnostics import SceneError, UsageError, render_text, usage_errors
from scenelang.grammar.settings import picture_size
from scenelang.session.loaded import AnyScene, LoadedScene, scene_of
from scenelang.session.session import Options
from scenelang.viewer.workspace import ParamControl, controls_of

if TYPE_CHECKING:
    from IPython.core.interactiveshell import InteractiveShell

_CELL = "<cell>"
_MAX_PRIMITIVES = 2_000_000  # of the viewer, as for ``Scene.show``
_VIEWER_HEIGHT_PX = 520  # of the viewer's iframe
Read = TypeVar("Read")


@dataclass(frozen=True, slots=True)
class CellOptions:
    """Display options of a cell.

    ``variable`` is the notebook variable that receives the scene; ``is_interactive`` shows the viewer instead of an
    image.
    """

    variable: str = "scene"
    size: tuple[int, int] = (480, 360)
    quality: str = "draft"
    camera: View | None = None
    frame: int | None = None
    is_interactive: bool = False

    def shown(self, scene: LoadedScene) -> Any:
        """Return the displayable object of ``scene``; raises SceneError."""
        if self.is_interactive:
            return ViewerPage(page_of(scene.graph, _MAX_PRIMITIVES), _VIEWER_HEIGHT_PX)
        options = picture_options(self.camera, self.size, frame=self.frame, warn=_warn)
        return image_of(scene.graph, options, self.quality)


def register(shell: InteractiveShell, kind: type[LoadedScene]) -> None:
    """Register ``%%scene`` with a running IPython.

    The magic evaluates and displays the cell, and assigns a scene of the class ``kind`` to a variable.
    """
    from IPython.core.magic_arguments import MagicArgumentParser

    parser = MagicArgumentParser(
        "%%scene",
        description="Evaluate the cell as a scene program, display the scene, and assign it to a variable. "
        "If ipywidgets is installed, params of the program become controls.",
    )
    parser.add_argument("variable", nargs="?", default="scene", help="variable to assign (default: scene)")
    parser.add_argument("--size", default="480x360", metavar="WxH", help="image size in pixels")
    parser.add_argument("--quality", default="draft", metavar="NAME", help="draft, final, or a rendering backend")
    parser.add_argument("--camera", default=None, metavar="SPEC", help="camera, such as azimuth=40,elevation=20")
    parser.add_argument("--frame", type=int, default=None, metavar="N", help="frame of a 4D scene, counted from 0")
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="random seed")
    parser.add_argument("--root", default=None, metavar="WORD", help="word to evaluate")
    parser.add_argument("--view", action="store_true", help="show the interactive viewer")
    parser.add_argument("--no-widgets", action="store_true", help="use the defaults of params, without controls")

    def scene(line: str, cell: str) -> None:
        try:
            arguments = parser.parse_argstring(line)
        except ValueError as error:  # quotes that are not closed
            print(f"error: {error}", file=sys.stderr)
            return
        with_errors(lambda: _run(arguments, cell, shell.user_ns, kind))

    scene.__doc__ = parser.format_help()
    shell.register_magic_function(scene, "cell", "scene")


def _run(arguments: Any, cell: str, variables: dict[str, Any], kind: type[LoadedScene]) -> None:
    """Evaluate and show a cell with its arguments; raises UsageError for invalid ones."""
    camera = _checked(view_of, arguments.camera) if arguments.camera else None
    if not arguments.variable.isidentifier() or iskeyword(arguments.variable):
        raise UsageError("value", f"expected a variable name, got `{arguments.variable}`")
    size = _checked(picture_size, arguments.size)
    options = CellOptions(arguments.variable, size, arguments.quality, camera, arguments.frame, arguments.view)
    scene = scene_of(kind, Source(_CELL, cell), Options(root=arguments.root, seed=arguments.seed))
    show(scene, options, variables, has_widgets=not arguments.no_widgets)


def _checked(read: Callable[[str], Read], text: str) -> Read:
    """Return ``read(text)``; raises UsageError for an invalid text."""
    with usage_errors():
        try:
            return read(text)
        except ValueError as error:
            raise SceneError("value", str(error)) from None


def with_errors(action: Callable[[], None]) -> None:
    """Run ``action``; print SceneErrors as diagnostics without a traceback."""
    try:
        action()
    except SceneError as error:
        print(error, file=sys.stderr)


def show(scene: LoadedScene, options: CellOptions, variables: dict[str, Any], has_widgets: bool = True) -> None:
    """Assign ``scene`` in ``variables`` and display it, with controls for its params if ipywidgets is installed."""
    from IPython.display import display

    for line in scene.log:
        print(line)
    for warning in scene.warnings:
        _warn(warning)
    controls = [c for c in _controls(scene) if c.kind in _WIDGETS] if has_widgets else []
    if not controls or find_spec("ipywidgets") is None:
        view = options.shown(scene)
        variables[options.variable] = scene
        display(view)
        return
    display(_panel(scene, options, variables, controls))


def _controls(scene: LoadedScene) -> tuple[ParamControl, ...]:
    """Return the controls of a scene's params, none without a program."""
    return () if scene.program is None else controls_of(scene.program.params)


def _panel(scene: LoadedScene, options: CellOptions, variables: dict[str, Any], controls: list[ParamControl]) -> Any:
    """Display controls above the image; each change evaluates the program again, and an error keeps the last scene."""
    import ipywidgets
    from IPython.display import display

    output = ipywidgets.Output()
    widgets = {control.param.name: (control, _widget(control)) for control in controls}

    first = options.shown(scene)  # before the output exists, which would print its own traceback

    def draw(new_scene: LoadedScene, view: Any = None) -> None:
        """Assign and display a scene."""
        view = options.shown(new_scene) if view is None else view
        variables[options.variable] = new_scene
        output.clear_output(wait=True)
        display(view)

    def changed(_: Any) -> None:
        """Evaluate the program with the values of the controls."""
        with output:
            with_errors(lambda: draw(_with_defines(scene, {n: c.literal(w.value) for n, (c, w) in widgets.items()})))

    with output:
        draw(scene, first)
    for _, widget in widgets.values():
        widget.observe(changed, names="value")
    return ipywidgets.VBox([*(widget for _, widget in widgets.values()), output])


def _with_defines(scene: AnyScene, texts: Mapping[str, str]) -> AnyScene:
    """Evaluate the scene with other values of its params, given as literals of the language."""
    assert scene.program is not None
    assert scene.options is not None
    return scene_of(type(scene), scene.program.main, replace(scene.options, defines=texts))


def _widget(control: ParamControl) -> Any:
    """Create the ipywidget of a param: a slider if it has both bounds."""
    import ipywidgets

    param = control.param
    facts: dict[str, Any] = {"value": control.value, "description": param.name, "tooltip": param.doc}
    if control.kind in ("integer", "number"):
        if param.minimum is not None and param.maximum is not None:
            number = int if control.kind == "integer" else float
            low, high = number(param.minimum), number(param.maximum)
            step = 1 if control.kind == "integer" else (high - low) / 100.0
            slider = ipywidgets.IntSlider if control.kind == "integer" else ipywidgets.FloatSlider
            return slider(min=low, max=high, step=step, continuous_update=False, **facts)
        return (ipywidgets.IntText if control.kind == "integer" else ipywidgets.FloatText)(**facts)
    return getattr(ipywidgets, _WIDGETS[control.kind])(**facts)


_WIDGETS = {
    "integer": "IntSlider", "number": "FloatSlider", "boolean": "Checkbox", "text": "Text", "color": "ColorPicker",
}  # fmt: skip


def _warn(warning: Any) -> None:
    """Print a warning on standard error, without an exception, as IPython's own magics do."""
    print(render_text(warning), file=sys.stderr)
