"""What would be sent, for people to read."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any


def payload_text(payload: Mapping[str, Any]) -> str:
    """What would be sent, for people: texts as they are, pictures by their size."""
    lines = [f"{name}: {json.dumps(value)}" for name, value in payload.items() if name not in ("system", "messages")]
    system = payload.get("system")
    if system is not None:
        lines += ["", "--- system ---", *(_part_text(part) for part in _parts(system))]
    for message in payload.get("messages", ()):
        lines += ["", f"--- {message['role']} ---", *(_part_text(part) for part in _parts(message["content"]))]
    return "\n".join(lines)


def _parts(content: Any) -> list[Any]:
    return [{"type": "text", "text": content}] if isinstance(content, str) else list(content)


def _part_text(part: Mapping[str, Any]) -> str:
    if part.get("type") == "text":
        return str(part["text"])
    return f"[a picture, {len(json.dumps(part)) * 3 // 4:,} bytes]"
