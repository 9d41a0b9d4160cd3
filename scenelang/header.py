"""What the comment at the head of a program says that it shows."""

from __future__ import annotations

import re

_TASK = re.compile(r"task\s*:\s*(.+)", re.I)
_SENTENCE = re.compile(r"(?<=[.!?])\s+")


def stated_task(text: str) -> str | None:
    """What a program of the language is to show: the line `; task: ...` of its leading comment, else the first sentence
    there, without its full stop; None where it begins with no comment."""
    lines: list[str] = []
    for line in text.lstrip("\ufeff").splitlines():
        stripped = line.strip()
        if stripped.startswith(";"):
            lines.append(stripped.lstrip(";").strip())
        elif stripped or lines:
            break
    for line in lines:
        task = _TASK.match(line)
        if task is not None:
            return task[1].strip()
    paragraph: list[str] = []
    for line in lines:
        if not line and paragraph:
            break
        paragraph += [line] if line else []
    first = _SENTENCE.split(" ".join(paragraph), maxsplit=1)[0].rstrip(".").strip()
    return first or None
