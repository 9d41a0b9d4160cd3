"""The live viewer beside a REPL: it shows what the session has defined, and follows it."""

from __future__ import annotations

import shutil
import tempfile
import threading
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.source import Source
from scenelang.repl.evaluation import Evaluation
from scenelang.repl.saving import program_text
from scenelang.sandbox.worker import Worker
from scenelang.session import Options, Session
from scenelang.viewer import workspace
from scenelang.viewer.server import ViewServer

_NAME = "session.scene"


class _TextSession(Session):
    """Reads the session's text, and finds imports beside the file that the REPL was opened with."""

    def __init__(self, options: Options, folder: Path) -> None:
        super().__init__(options)
        self._beside = folder

    def source(self, path: str) -> Source:
        return Source(str(self._beside / _NAME), super().source(path).text)


class LiveView:
    """A server in the background. Raises SceneError when nothing is defined yet."""

    def __init__(self, evaluation: Evaluation) -> None:
        self._evaluation = evaluation
        if not program_text(evaluation.top):
            raise SceneError("no-root", "nothing has been defined, so there is nothing to view")
        self._folder = Path(tempfile.mkdtemp(prefix="scenelang-"))
        self._text = ""
        self.update()
        self._worker = Worker(self._evaluate)
        ask = lambda file, values: self._worker.ask(file, values, self._options())
        self._server = ViewServer(workspace.Workspace([str(self._folder / _NAME)], ask))
        threading.Thread(target=self._server.serve_forever, args=(0.2,), daemon=True).start()

    @property
    def address(self) -> str:
        return self._server.address

    def _options(self) -> Options:
        return replace(self._evaluation.session.options, seed=self._evaluation.seed)

    def _evaluate(self, file: str, values: Mapping[str, str], options: Options) -> workspace.Evaluation:
        """Runs in a process of the worker, which has the session as it was when the viewer was opened."""

        def open_session(_: str, values: Mapping[str, str]) -> Session:
            chosen = replace(options, defines={**options.defines, **values})
            return _TextSession(chosen, self._evaluation.folder)

        return workspace.evaluator(open_session, options.limits.primitives)(file, values)

    def update(self) -> None:
        """Show what is defined now."""
        text = program_text(self._evaluation.top)
        if text != self._text:
            self._text = text
            (self._folder / _NAME).write_text(text, "utf-8")

    def open_browser(self) -> None:
        """Open the page where there is a screen for it."""
        from scenelang.cli.view import has_screen

        if has_screen():
            import webbrowser

            webbrowser.open(self.address)

    def again(self) -> LiveView:
        """Another viewer in the place of one whose threads are gone."""
        self._server.socket.close()
        shutil.rmtree(self._folder, ignore_errors=True)
        return LiveView(self._evaluation)

    def close(self) -> None:
        """End the server and remove its file."""
        self._server.shutdown()
        self._server.server_close()
        self._worker.close()
        shutil.rmtree(self._folder, ignore_errors=True)
