"""Files of Gaussians: the ``.ply`` of 3D Gaussian Splatting and the ``.splat`` of 32 bytes each, written and read.

Coordinates are kept as they are, the scene's: x right, y up, z towards the viewer, in scene units. Colours in files are
sRGB; here they are linear. Reading is bounded, and never believes what a file says of its size.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import require
from scenelang.backends.exports.mesh_files import write_ply
from scenelang.backends.files import atomic_write, read_regular
from scenelang.backends.neural.splats.gaussians import Gaussians
from scenelang.backends.neural.weights import INSTALL
from scenelang.backends.pictures.studio import from_srgb, to_srgb
from scenelang.grammar.diagnostics import LimitError, SceneError

if TYPE_CHECKING:
    from torch import Tensor


FloatArray = npt.NDArray[np.float64]

C0 = 0.28209479177387814  # the constant spherical harmonic: a colour is 0.5 + C0 f_dc
MOST = 20_000_000
_LARGEST = 8 << 30  # bytes
_LONGEST_HEADER = 1 << 16
_MOST_PROPERTIES = 1_000
_NAMES = (
    *("x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2", "opacity"),
    *("scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"),
)
_UNREAD = ("nx", "ny", "nz")
_TYPES = {
    "char": "i1",
    "uchar": "u1",
    "short": "<i2",
    "ushort": "<u2",
    "int": "<i4",
    "uint": "<u4",
    "int8": "i1",
    "uint8": "u1",
    "int16": "<i2",
    "uint16": "<u2",
    "int32": "<i4",
    "uint32": "<u4",
    "float": "<f4",
    "double": "<f8",
    "float32": "<f4",
    "float64": "<f8",
}
_SPLAT = np.dtype([("place", "<f4", 3), ("scale", "<f4", 3), ("color", "u1", 4), ("turn", "u1", 4)])
_ROOM = 60.0  # logarithms of scales and odds beyond it are none of a Gaussian's
_FARTHEST = 1e30


# --- writing ---------------------------------------------------------------------------------------------------


def write_gaussians(gaussians: Gaussians, path: Path) -> None:
    """Write ``path``, a ``.splat`` by its ending or else a ``.ply``, whole or not at all. Raises SceneError("file")."""
    rows = splat_rows(gaussians) if path.suffix.lower() == ".splat" else None
    with atomic_write(path) as temporary:
        if rows is not None:
            temporary.write_bytes(rows.tobytes())
        else:
            comment = "scenelang: y up, colours are sRGB"
            write_ply(temporary, [("float", name) for name in _NAMES], [ply_rows(gaussians)], None, comment)


def ply_rows(gaussians: Gaussians) -> npt.NDArray[np.float32]:
    """The rows (N, 17) of a ``.ply``: place, no normal, colour, opacity's logit, scales' logarithms, turn w first."""
    rows = np.zeros((len(gaussians), len(_NAMES)), np.float32)
    rows[:, 0:3] = _array(gaussians.means)
    rows[:, 6:9] = (to_srgb(_array(gaussians.colors)) - 0.5) / C0
    rows[:, 9] = _array(gaussians.opacity_logits)
    rows[:, 10:13] = _array(gaussians.log_scales)
    rows[:, 13:17] = _turns(gaussians)
    return rows


def splat_rows(gaussians: Gaussians) -> npt.NDArray[np.void]:
    """The rows (N,) of a ``.splat``, in which colours, opacities and turns have 8 bits; the largest and most opaque
    first, as its readers draw them while they load."""
    rows = np.zeros(len(gaussians), _SPLAT)
    scales, opacities = np.exp(_array(gaussians.log_scales)), _array(gaussians.opacities)
    rows["place"], rows["scale"] = _array(gaussians.means), scales
    rows["color"][:, :3] = np.rint(255.0 * to_srgb(_array(gaussians.colors)))
    rows["color"][:, 3] = np.rint(255.0 * opacities)
    rows["turn"] = np.clip(np.rint(_turns(gaussians) * 128.0 + 128.0), 0.0, 255.0)
    return rows[np.argsort(-scales.prod(axis=1) * opacities, kind="stable")]


def _array(tensor: Tensor) -> FloatArray:
    return np.asarray(tensor.detach().cpu().double().numpy(), np.float64)


def _turns(gaussians: Gaussians) -> FloatArray:
    turns = _array(gaussians.quaternions)
    return np.asarray(turns / np.linalg.norm(turns, axis=1, keepdims=True), np.float64)


# --- reading ---------------------------------------------------------------------------------------------------


def read_gaussians(path: Path | str) -> Gaussians:
    """The Gaussians of a ``.splat`` by its ending, else of a ``.ply``, in 32 bits; what depends on the direction of
    view (``f_rest_*``) is left out.

    Raises SceneError: "file" where the file cannot be read or holds no Gaussians, "backend" without torch; LimitError
    for more than MOST.
    """
    target = Path(path)
    require("torch", INSTALL)
    try:
        if target.stat().st_size > _LARGEST:
            raise LimitError("size", f"`{target}` is larger than {_LARGEST:,} bytes")
        data = read_regular(target)
    except OSError as error:
        raise SceneError("file", f"cannot read {target}: {error.strerror or error}") from error
    return from_splat(data) if target.suffix.lower() == ".splat" else from_ply(data)


def from_splat(data: bytes) -> Gaussians:
    """The Gaussians of a ``.splat`` file's bytes; raises as ``read_gaussians`` does."""
    count, rest = divmod(len(data), _SPLAT.itemsize)
    if rest:
        raise _wrong(f"a .splat file has {_SPLAT.itemsize} bytes for each Gaussian, and this one {rest} more")
    _check_count(count)
    rows = np.frombuffer(data, _SPLAT)
    scales = rows["scale"].astype(np.float64)
    if not (np.isfinite(scales) & (scales >= 0.0)).all():
        raise _wrong("a scale is negative or no number")
    shares = np.clip(rows["color"][:, 3] / 255.0, 1e-3, 1.0 - 1e-3)
    logs = np.log(np.maximum(scales, np.exp(-_ROOM)))
    turns = (rows["turn"].astype(np.float64) - 128.0) / 128.0
    return _gaussians(rows["place"], logs, turns, np.log(shares / (1.0 - shares)), rows["color"][:, :3] / 255.0)


def from_ply(data: bytes) -> Gaussians:
    """The Gaussians of a ``.ply`` file's bytes; raises as ``read_gaussians`` does."""
    header = _header(data)
    rows = np.frombuffer(data, header.row, header.count, header.start)
    return _gaussians(
        _columns(rows, "x", "y", "z"),
        _columns(rows, "scale_0", "scale_1", "scale_2"),
        _columns(rows, "rot_0", "rot_1", "rot_2", "rot_3"),
        _columns(rows, "opacity")[:, 0],
        0.5 + C0 * _columns(rows, "f_dc_0", "f_dc_1", "f_dc_2"),
    )


def _columns(rows: npt.NDArray[np.void], *names: str) -> FloatArray:
    return np.stack([rows[name].astype(np.float64) for name in names], axis=1)


@dataclass(frozen=True, slots=True)
class _Header:
    """``count`` rows of the type ``row`` from byte ``start`` on."""

    row: np.dtype[Any]
    count: int
    start: int


def _header(data: bytes) -> _Header:
    """What a ``.ply`` file says of itself, checked against its size."""
    end = re.search(rb"\nend_header\r?\n", data[:_LONGEST_HEADER])
    if not data.startswith(b"ply") or end is None:
        raise _wrong("it does not begin as a .ply file does")
    lines = [line.split() for line in data[: end.start()].decode("ascii", "replace").splitlines()[1:]]
    lines = [words for words in lines if words and words[0] not in ("comment", "obj_info")]
    if not lines or lines[0] != ["format", "binary_little_endian", "1.0"]:
        raise _wrong("only .ply files in the format binary_little_endian 1.0 hold Gaussians")
    if len(lines) < 2 or lines[1][:2] != ["element", "vertex"] or len(lines[1]) != 3 or not _is_count(lines[1][2]):
        raise _wrong("its first element must be `vertex`, with a whole number")
    count, fields = int(lines[1][2]), _fields(lines[2:])
    _check_count(count)
    row = np.dtype(fields)
    if end.end() + count * row.itemsize > len(data):
        raise _wrong(f"it ends before the {count:,} Gaussians that it announces")
    return _Header(row, count, end.end())


def _fields(lines: list[list[str]]) -> list[tuple[str, str]]:
    """The properties of the vertices: names with types."""
    found: dict[str, str] = {}
    for words in lines:
        if words[0] != "property":
            break
        if len(words) != 3 or words[1] not in _TYPES or words[2] in found or len(found) >= _MOST_PROPERTIES:
            raise _wrong(f"unknown Gaussian property `{' '.join(words)[:60]}`")
        found[words[2]] = _TYPES[words[1]]
    missing = [name for name in _NAMES if name not in found and name not in _UNREAD]
    if missing:
        raise _wrong(f"it has no property `{missing[0]}`, so it holds no Gaussians")
    return list(found.items())


def _is_count(text: str) -> bool:
    return text.isascii() and text.isdigit() and len(text) < 12


def _check_count(count: int) -> None:
    if count > MOST:
        raise LimitError("size", f"the file has {count:,} Gaussians, more than the {MOST:,} that are read")


def _gaussians(
    places: npt.NDArray[Any], logs: FloatArray, turns: FloatArray, logits: FloatArray, srgb: FloatArray
) -> Gaussians:
    """The Gaussians of a file's numbers; raises SceneError("file") where these are none."""
    import torch

    for what, values in (("place", places), ("scale", logs), ("turn", turns), ("opacity", logits), ("color", srgb)):
        if not (np.abs(values) < _FARTHEST).all():
            raise _wrong(f"a Gaussian's {what} is not a finite number in range")
    if (np.abs(logs) > _ROOM).any():
        raise _wrong("a Gaussian's scale is far too large or too small")
    if (np.linalg.norm(turns, axis=1) < 1e-6).any():
        raise _wrong("a Gaussian has no direction: its quaternion is 0")
    columns = (places, logs, turns, np.clip(logits, -_ROOM, _ROOM), from_srgb(srgb))
    return Gaussians(*(torch.from_numpy(np.array(column, np.float32)) for column in columns))


def _wrong(message: str) -> SceneError:
    return SceneError("file", f"the file holds no Gaussians: {message}")
