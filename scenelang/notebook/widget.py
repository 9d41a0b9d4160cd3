"""Widget of Jupyter: the studio's page in a cell, with the kernel as its interpreter (docs/python.md)."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from scenelang.backends.viewer.packet import frame_page
from scenelang.grammar.datum import Source
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.loading import require
from scenelang.session.loaded import LoadedScene, scene_of
from scenelang.session.session import Options, Session, definition
from scenelang.viewer.answers import PageAnswers
from scenelang.viewer.program_tools import tools
from scenelang.viewer.workspace import STARTER, Workspace, evaluator, saved_page

require("anywidget", "'scenelang[notebook]'")  # before the class, which is made of it
import anywidget  # noqa: E402
import traitlets  # noqa: E402

_NAME = "cell.scene"
_MAX_PRIMITIVES = 2_000_000  # as for ``Scene.show``

# Passes questions of the page, which is a frame without rights, to the kernel, and answers back.
_SCRIPT = """
function render({ model, el }) {
  const frame = document.createElement("iframe");
  frame.setAttribute("sandbox", "allow-scripts allow-downloads");
  frame.title = "Scene Language studio";
  frame.style.cssText = `width: 100%; height: ${model.get("height")}px; border: 1px solid #8884;`;
  frame.srcdoc = model.get("page");
  const ask = (event) => { if (event.source === frame.contentWindow) model.send(event.data); };
  const tell = (answer, buffers) => {
    const part = buffers?.[0];
    const bytes = part && new Uint8Array(part.buffer, part.byteOffset, part.byteLength).slice().buffer;
    frame.contentWindow?.postMessage({ ...answer, bytes }, "*");
  };
  const write = () => frame.contentWindow?.postMessage({ text: model.get("text") }, "*");
  addEventListener("message", ask);
  model.on("msg:custom", tell);
  model.on("change:text", write);
  el.append(frame);
  return () => {
    removeEventListener("message", ask);
    model.off("msg:custom", tell);
    model.off("change:text", write);
  };
}
export default { render };
"""


class StudioWidget(anywidget.AnyWidget):
    """A program with its live scene in a cell of a notebook.

    Attributes
    ----------
    text : str
        The program; what is typed in the page is here, and what is assigned appears there.
    params : dict
        Values of the program's params, as they are in the text. Read only.
    selection : str
        Path of the selected object, such as ``chair/leg[2]``; empty for none. Read only.
    height : int
        Of the cell, in pixels.

    Examples
    --------
    >>> studio = StudioWidget('(param size 1.0) (bind "ball" (lambda () (call "sphere" :radius size)))')
    >>> studio.params
    {'size': 1.0}
    """

    _esm = _SCRIPT
    page = traitlets.Unicode().tag(sync=True)
    text = traitlets.Unicode().tag(sync=True)
    params = traitlets.Dict().tag(sync=True)
    selection = traitlets.Unicode().tag(sync=True)
    height = traitlets.Int(560).tag(sync=True)

    def __init__(self, text: str = STARTER, height: int = 560) -> None:
        """Evaluate a program, to be shown as the last value of a cell or by ``display``."""
        self._folder = tempfile.TemporaryDirectory(prefix="scenelang-")
        self._file = Path(self._folder.name, _NAME)
        self._file.write_text(text, encoding="utf-8")
        workspace = Workspace([str(self._file)], evaluator(_open_session, _MAX_PRIMITIVES), tools(_open_session))
        self._answers = PageAnswers("notebook", lambda message: self.send({"lsp": message}), workspace, [_NAME])
        super().__init__(page=frame_page(), text=text, height=height)
        self._update_params()
        self.on_msg(self._asked)
        self.observe(self._text_assigned, "text")

    @property
    def scene(self) -> LoadedScene:
        """The scene of the program; raises SceneError for a wrong program."""
        return scene_of(LoadedScene, Source(_NAME, self.text), Options())

    def _text_assigned(self, change: Mapping[str, Any]) -> None:
        """Evaluate a text that Python assigned; the page's own has been evaluated."""
        if self._file.read_text(encoding="utf-8") != change["new"]:
            self._edit(0, change["new"])

    def _update_params(self) -> None:
        self.params = {control.param.name: control.value for control in self._answers.workspace.state(0).controls}

    # --- what the page asks

    def _asked(self, _: Any, message: Any, buffers: Any) -> None:
        """Answer a question of the page; errors of the user become messages there."""
        method = message.get("method") if isinstance(message, dict) else None
        answer = self._own_answers().get(method) or (getattr(self._answers, method) if method in _ASKED else None)
        if answer is None:
            return
        try:
            result = answer(*message.get("values", ()))
        except SceneError as error:
            hint = f"; {error.hint}" if error.hint else ""
            self.send({"id": message.get("id"), "error": error.message + hint})
            return
        if isinstance(result, bytes):
            self.send({"id": message.get("id")}, buffers=[result])
        else:
            self.send({"id": message.get("id"), "result": result})

    def _own_answers(self) -> dict[str | None, Callable[..., Any]]:
        """Return what the widget itself answers, by the method of the question."""
        return {
            "files": lambda: [_NAME], "uris": lambda: [self._file.as_uri()],
            "text": lambda file: {"name": _NAME, "text": self.text}, "edit": self._edit, "selected": self._selected,
        }  # fmt: skip

    def _edit(self, file: int, text: str | None) -> dict[str, Any]:
        state = self._answers.edit(file, text)
        if text is not None:
            self.text = text
        self._update_params()
        return state

    def _selected(self, path: str) -> None:
        self.selection = str(path)

    def _repr_mimebundle_(self, **options: Any) -> Any:
        """Add the scene as a page of its own, for where no kernel answers: exported HTML."""
        bundle = super()._repr_mimebundle_(**options)
        page = saved_page(self._answers.workspace, lambda diagnostics: None)
        if bundle is not None and page is not None:
            from scenelang.backends.viewer.packet import ViewerPage

            data = bundle[0] if isinstance(bundle, tuple) else bundle
            data["text/html"] = ViewerPage(page, self.height)._repr_html_()
        return bundle


def _open_session(path: str, values: Mapping[str, str]) -> Session:
    """Create the session of a program, with values of the sliders for its params."""
    return Session(Options(defines=dict(definition(f"{name}={text}") for name, text in values.items())))


_ASKED = ("state", "picture", "set", "literal", "change", "lsp")  # of ``PageAnswers``
