"""Language server without streams: messages come and go as JSON texts, for a page that talks to it."""

from __future__ import annotations

import json
import logging
from collections.abc import Callable

from scenelang.lsp.server import build_server


class _Writer:
    """What the protocol writes to: a function."""

    def __init__(self, send: Callable[[str], None]) -> None:
        self._send = send

    def write(self, data: bytes) -> None:
        """Send one message."""
        self._send(data.decode())

    def close(self) -> None:
        """Do nothing; the channel ends with its owner."""


class Channel:
    """Language server of one page.

    ``receive`` must be called in a running asyncio loop, in which the server answers by ``send``.
    """

    def __init__(self, version: str, send: Callable[[str], None]) -> None:
        logging.getLogger("pygls").setLevel(logging.CRITICAL)
        self._server = build_server(version)
        self._server.protocol.set_writer(_Writer(send), include_headers=False)

    def receive(self, text: str) -> None:
        """Handle a message of the page; one that is no message is ignored, as the protocol says."""
        protocol = self._server.protocol
        try:
            message = json.loads(text, object_hook=protocol.structure_message)
        except (ValueError, RecursionError, TypeError, KeyError):
            return
        protocol.handle_message(message)
