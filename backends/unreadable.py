"""Errors of files that cannot be read as text: what is there instead, and what to do."""

from __future__ import annotations

import os
from collections.abc import Iterator

from scenelang.grammar.diagnostics import SceneError, close_matches

_WILDCARDS = "*?["
_MIN_NAME_RATIO = 0.7  # of difflib, between a file's name and the one that was meant
_MAX_LISTED = 5  # files in a hint

# The first bytes of files that are no text, with what they are and what to do with a file NAME.
_MAGIC: tuple[tuple[bytes, str, str], ...] = (
    (b"\x1f\x8b", "compressed by gzip", "unpack it: `gunzip -c {name} > NEW.scene`"),
    (b"BZh", "compressed by bzip2", "unpack it: `bunzip2 -c {name} > NEW.scene`"),
    (b"\xfd7zXZ", "compressed by xz", "unpack it: `xz -dc {name} > NEW.scene`"),
    (b"\x28\xb5\x2f\xfd", "compressed by zstd", "unpack it: `zstd -dc {name} > NEW.scene`"),
    (b"PK\x03\x04", "a ZIP archive", "unpack it: `unzip {name}`"),
    (b"\x89PNG", "a picture (PNG)", "name a program"),
    (b"\xff\xd8\xff", "a picture (JPEG)", "name a program"),
    (b"GIF8", "a picture (GIF)", "name a program"),
    (b"RIFF", "a picture (WebP)", "name a program"),
    (b"%PDF", "a PDF document", "name a program"),
    (b"glTF", "a mesh (GLB)", 'use it in a program by `(call "mesh" :file "{name}")`'),
    (b"BLENDER", "a file of Blender", "export a GLB there, and use that as a mesh"),
    (b"\x7fELF", "an executable", "name a program"),
)
_WIDE = {b"\xff\xfe": "UTF-16", b"\xfe\xff": "UTF-16"}  # byte order marks


def unreadable(path: str, shown: str, reason: str, hint: str | None = None) -> SceneError:
    """Return the error for a file that cannot be read; one that does not exist is told with what is there.

    Parameters
    ----------
    path, shown
        Path of the file, and as the user knows it.
    reason, hint
        Reason of the system, and a hint, for a file that exists.
    """
    if os.path.isdir(path):
        programs = [name for name in _files_in(path) if name.endswith(".scene")]
        listed = ", ".join(os.path.join(shown, name) for name in programs[:_MAX_LISTED])
        advice = f"name one file, such as {listed}" if listed else hint
        return SceneError("file", f"{shown} is a folder", advice)
    if os.path.lexists(path) or "\0" in path or not shown:
        return SceneError("file", f"cannot read {shown}: {reason}", hint)
    folder, name = os.path.split(path)
    shown_folder = os.path.dirname(shown)
    if any(mark in shown for mark in _WILDCARDS):
        return SceneError("file", f"no file matches `{shown}`", _content_of(folder, shown_folder, name))
    if folder and not os.path.isdir(folder):
        missing = _first_missing(folder, shown_folder)
        remark = "" if os.path.splitext(name)[1] else "; a program ends in .scene"
        return SceneError("file", f"there is no file {shown}", f"the folder {missing} does not exist{remark}")
    meant = _nearest(name, _files_in(folder))
    if meant is not None:
        return SceneError("file", f"there is no file {shown}", f"did you mean `{os.path.join(shown_folder, meant)}`?")
    return SceneError("file", f"there is no file {shown}", _content_of(folder, shown_folder, name))


def _nearest(name: str, others: list[str]) -> str | None:
    """Return the file whose name is most like another one; None if none is.

    A file with the same ending comes first, or a program: the image that was made of it has its name as well.
    """
    stem, ending = os.path.splitext(name.lower())
    for endings in ((ending,), (".scene", ".py")):
        alike = {os.path.splitext(each)[0].lower(): each for each in others if each.lower().endswith(endings)}
        near = close_matches(stem, alike, 1, _MIN_NAME_RATIO) if ending else []
        if near:
            return alike[near[0]]
    stems = {os.path.splitext(other)[0].lower(): other for other in reversed(others)}
    same = [other for other in others if other.lower() == name.lower()]
    near = close_matches(stem, stems, 1, _MIN_NAME_RATIO)
    return same[0] if same else stems[near[0]] if near else None


def _first_missing(folder: str, shown: str) -> str:
    """Return the outermost folder of a path that does not exist, as the user knows it."""
    while (parent := os.path.dirname(folder)) and parent != folder and not os.path.isdir(parent):
        folder, shown = parent, os.path.dirname(shown) or shown
    return shown or folder


def _files_in(folder: str) -> list[str]:
    """Return the names in a folder that are not hidden, in order."""
    try:
        return sorted(name for name in os.listdir(folder or ".") if not name.startswith("."))
    except OSError:
        return []


def _content_of(folder: str, shown: str, name: str) -> str:
    """Return the hint that lists the files of a folder with the ending of a name."""
    ending = os.path.splitext(name)[1] or ".scene"
    place = f"the folder {shown}" if shown else "this folder"
    if folder and not os.path.isdir(folder):
        return f"{place} does not exist"
    names = [other for other in _files_in(folder) if other.endswith(ending)]
    if not names:
        return f"{place} has no {ending} files"
    if len(names) > _MAX_LISTED:  # a choice of many would be arbitrary
        return f"{place} has {len(names)} other {ending} files"
    return f"{place} has {', '.join(names)}"


def undecodable(data: bytes, name: str, error: UnicodeDecodeError) -> SceneError:
    """Return the error for a file that is not UTF-8: what its first bytes show that it is, and what to do."""
    for magic, kind, advice in _MAGIC:
        if data.startswith(magic):
            return SceneError("encoding", f"{name} is {kind}, not text", advice.format(name=name))
    encoding = next(_wide_encodings(data), None)
    if encoding is not None:
        command = f"iconv -f {encoding} -t UTF-8 {name} > NEW.scene"
        hint = f"save it as UTF-8: `{command}`, or by `Out-File -Encoding utf8` in PowerShell"
        return SceneError("encoding", f"{name} is encoded as {encoding}, not as UTF-8", hint)
    if b"\0" in data:
        return SceneError("encoding", f"{name} is a binary file, not text", "name a program")
    line = data[: error.start].count(b"\n") + 1
    hint = f"save it as UTF-8: `iconv -f LATIN1 -t UTF-8 {name} > NEW.scene`, if it is of an older editor"
    return SceneError("encoding", f"{name} is not UTF-8 text (line {line}, byte {error.start + 1})", hint)


def _wide_encodings(data: bytes) -> Iterator[str]:
    """Iterate over the encodings of two bytes for a character that a text has."""
    for mark, encoding in _WIDE.items():
        if data.startswith(mark):
            yield encoding
    if data[1::2].count(0) * 3 > len(data):
        yield "UTF-16LE"
    if data[::2].count(0) * 3 > len(data):
        yield "UTF-16BE"
