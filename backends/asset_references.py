"""What a mesh file refers to: other files, which must lie inside one folder, and pictures, which must not be too large.

The library that reads meshes gets these files from here only, so that neither its version nor its own rules decide what
is read.
"""

from __future__ import annotations

import io
import re
import warnings
from pathlib import Path
from urllib.parse import unquote

from scenelang.backends.base import need
from scenelang.grammar.diagnostics import SceneError

LARGEST_FILE = 128_000_000  # bytes, of a mesh file and of all that it refers to
MOST_PIXELS = 1 << 25  # of all pictures of a mesh file together: 8192 x 4096
_PICTURES = ("PNG", "JPEG", "WEBP", "BMP", "GIF", "TGA", "TIFF", "PPM")  # formats whose decoder runs no other program
_SCHEME = re.compile(r"[A-Za-z][A-Za-z0-9+.\-]*:")


class References:
    """Reads the files that the mesh file ``path`` refers to, all of which lie in ``root``. It has the methods of a
    resolver of trimesh, which drops some errors on the way; the first of them is kept in ``problem``."""

    def __init__(self, path: Path, root: Path, decoded: bool) -> None:
        self.file_name = path.name
        self.file_path = str(path)
        self.problem: SceneError | None = None
        self._folder = path.parent.resolve()
        self._root = root.resolve()
        self._decoded = decoded
        self._read: dict[str, bytes] = {}
        self._room = LARGEST_FILE
        self._pixels = MOST_PIXELS

    def get(self, name: str) -> bytes:
        """The bytes of the file called ``name``; raises SceneError, or OSError for a file that is not there."""
        if name not in self._read:
            try:
                self._read[name] = self._bytes(name)
            except SceneError as problem:
                self.problem = self.problem or problem
                raise
        return self._read[name]

    __getitem__ = get

    def namespaced(self, namespace: str) -> References:
        """This resolver itself: names are those that the file says."""
        return self

    def keys(self) -> list[str]:
        """The names that were read."""
        return list(self._read)

    def picture(self, data: bytes, what: str) -> None:
        """Count the pixels of a picture before anything decodes it; raises SceneError for too many, or for a format
        that is not read. What is no picture passes."""
        size = _size_of(data)
        if size is None:
            return
        self._pixels -= size[0] * size[1]
        if self._pixels < 0:
            message = (
                f"{what} of the asset {self.file_name} has {size[0]:,} x {size[1]:,} pixels; all pictures of an asset"
            )
            raise SceneError("file", f"{message} together may have {MOST_PIXELS:,}")

    def _bytes(self, name: str) -> bytes:
        target = self._target(name)
        if not target.is_file():  # never a device or a pipe, which may have no end
            raise SceneError("file", f"the asset {self.file_name} refers to `{name[:80]}`, and there is no such file")
        size = target.stat().st_size
        self._room -= size
        if self._room < 0:
            message = f"the files that the asset {self.file_name} refers to have more than the {LARGEST_FILE:,} bytes"
            raise SceneError("file", f"{message} that they may")
        with target.open("rb") as file:
            data = file.read(size)
        self.picture(data, f"`{name[:80]}`")
        return data

    def _target(self, name: str) -> Path:
        """The path that ``name`` leads to, links followed."""
        plain = unquote(name) if self._decoded else name
        shown = f"the asset {self.file_name} refers to `{name[:80]}`, which"
        if _SCHEME.match(plain) or "\\" in plain or "\0" in plain or Path(plain).is_absolute() or plain[:1] == "/":
            raise SceneError("import-outside", f"{shown} is no path relative to it", hint=_HINT)
        try:
            target = (self._folder / plain).resolve()
        except (OSError, ValueError, RuntimeError):
            raise SceneError("file", f"{shown} is no path") from None
        if not target.is_relative_to(self._root):
            raise SceneError("import-outside", f"{shown} leads out of {self._root}", hint=_HINT)
        return target


_HINT = "an asset's buffers, materials and pictures lie in the project folder, or in the asset itself"


def _size_of(data: bytes) -> tuple[int, int] | None:
    """Width and height of a picture, from its head; None for what is no picture. Raises SceneError for pictures that
    are not read."""
    image = need("PIL.Image", "pillow")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", image.DecompressionBombWarning)
        try:
            with image.open(io.BytesIO(data)) as opened:
                kind, (width, height) = opened.format, opened.size
        except image.DecompressionBombError:
            raise SceneError("file", f"a picture of an asset may have {MOST_PIXELS:,} pixels at most") from None
        except Exception:  # a reader of foreign files may raise anything
            return None
    if kind not in _PICTURES:
        raise SceneError("file", f"a picture of an asset is a {kind}; it may be one of {', '.join(_PICTURES)}")
    return width, height
