"""Answers to a page whose interpreter is reached by messages: the playground's worker, and the notebook's kernel."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from scenelang.interpreter.plugins import SERVICES
from scenelang.viewer.workspace import Workspace, state_data


class PageAnswers:
    """Programs of a page, and what it asks about them.

    Methods take and return data of JSON, except ``picture``, which returns bytes. Those of users' mistakes raise
    SceneError.

    Parameters
    ----------
    client
        Name of the kind of page, for the language server.
    send
        Receives the messages of the language server.
    """

    def __init__(self, client: str, send: Callable[[str], None], workspace: Workspace, names: Sequence[str]) -> None:
        """Take over the files of a workspace, with the names that the page shows."""
        self.workspace, self.names = workspace, list(names)
        self._client, self._send = client, send
        self._channel: Any = None

    def state(self, file: int) -> dict[str, Any]:
        """Return the state of a program for the page."""
        return state_data(self.names[file], self.workspace.state(file), path=self.workspace.files[file])

    def edit(self, file: int, text: str | None) -> dict[str, Any]:
        """Write a program's new text and evaluate it; None evaluates it as it is."""
        if text is not None:
            Path(self.workspace.files[file]).write_text(text, encoding="utf-8")
        self.workspace.edit(file, text)
        return self.state(file)

    def set(self, file: int, name: str, value: Any) -> dict[str, Any]:
        """Try a value of a param."""
        self.workspace.state(file)
        self.workspace.try_value(file, name, value)
        return self.state(file)

    def literal(self, file: int, name: str, value: Any, text: str) -> dict[str, Any]:
        """Return the edit of a text that gives a param a value."""
        return self.workspace.literal_edit(file, name, value, text)

    def change(self, file: int, text: str, change: Mapping[str, Any]) -> dict[str, Any]:
        """Return a program in which the objects of a path are changed."""
        return self.workspace.use("change", file, text, change)

    def picture(self, file: int) -> bytes | None:
        """Return the last valid packet of a program."""
        return self.workspace.state(file).packet

    def lsp(self, message: str) -> None:
        """Pass a message to the language server, which is made by the first one; needs a running asyncio loop."""
        if self._channel is None:
            self._channel = SERVICES.find("language-server")(self._client, self._send)
        self._channel.receive(message)
