"""Files of Gaussians: ``.ply`` of 3D Gaussian Splatting, and ``.splat`` with 32 bytes per Gaussian.

Coordinates are those of the scene, unchanged: x right, y up, z towards the viewer, in scene units. Colors are sRGB in
files and linear in memory. Reading is bounded, and sizes in headers are checked against the size of the file.
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
from scenelang.backends.surfaces.image_files import from_srgb, to_srgb
from scenelang.grammar.diagnostics import LimitError, SceneError

if TYPE_CHECKING:
    from torch import Tensor


FloatArray = npt.NDArray[np.float64]

C0 = 0.28209479177387814  # spherical harmonic of degree 0, 1 / (2 sqrt(pi)); a color is 0.5 + C0 f_dc
MAX_GAUSSIANS = 20_000_000
_MAX_BYTES = 8 << 30
_MAX_HEADER_BYTES = 1 << 16
_MAX_PROPERTIES = 1_000
_NAMES = (
    *("x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2", "opacity"),
    *("scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"),
)
_OPTIONAL = ("nx", "ny", "nz")  # always 0 and ignored
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
_SPLAT = np.dtype([("position", "<f4", 3), ("scale", "<f4", 3), ("color", "u1", 4), ("rotation", "u1", 4)])
_MAX_LOG = 60.0  # of scales and of the odds of opacities, which exp can represent in float32
_MAX_VALUE = 1e30


# --- writing ---------------------------------------------------------------------------------------------------


def write_gaussians(gaussians: Gaussians, path: Path) -> None:
    """Write ``.splat`` or, for any other suffix, ``.ply``, atomically; raises SceneError("file")."""
    rows = splat_rows(gaussians) if path.suffix.lower() == ".splat" else None
    with atomic_write(path) as temporary:
        if rows is not None:
            temporary.write_bytes(rows.tobytes())
        else:
            comment = "scenelang: y up, colors are sRGB"
            write_ply(temporary, [("float", name) for name in _NAMES], [ply_rows(gaussians)], None, comment)


def ply_rows(gaussians: Gaussians) -> npt.NDArray[np.float32]:
    """Return the rows (N, 17) of a ``.ply``: position, zero normal, color, opacity logit, log scales, quaternion."""
    rows = np.zeros((len(gaussians), len(_NAMES)), np.float32)
    rows[:, 0:3] = _array(gaussians.means)
    rows[:, 6:9] = (to_srgb(_array(gaussians.colors)) - 0.5) / C0
    rows[:, 9] = _array(gaussians.opacity_logits)
    rows[:, 10:13] = _array(gaussians.log_scales)
    rows[:, 13:17] = _unit_quaternions(gaussians)
    return rows


def splat_rows(gaussians: Gaussians) -> npt.NDArray[np.void]:
    """Return the rows (N,) of a ``.splat``, with 8 bits per component of colors, opacities and quaternions.

    The largest and most opaque Gaussians are first, since viewers render while they load.
    """
    rows = np.zeros(len(gaussians), _SPLAT)
    scales, opacities = np.exp(_array(gaussians.log_scales)), _array(gaussians.opacities)
    rows["position"], rows["scale"] = _array(gaussians.means), scales
    rows["color"][:, :3] = np.rint(255.0 * to_srgb(_array(gaussians.colors)))
    rows["color"][:, 3] = np.rint(255.0 * opacities)
    rows["rotation"] = np.clip(np.rint(_unit_quaternions(gaussians) * 128.0 + 128.0), 0.0, 255.0)
    return rows[np.argsort(-scales.prod(axis=1) * opacities, kind="stable")]


def _array(tensor: Tensor) -> FloatArray:
    return np.asarray(tensor.detach().cpu().double().numpy(), np.float64)


def _unit_quaternions(gaussians: Gaussians) -> FloatArray:
    quaternions = _array(gaussians.quaternions)
    return np.asarray(quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True), np.float64)


# --- reading ---------------------------------------------------------------------------------------------------


def read_gaussians(path: Path | str) -> Gaussians:
    """Read the Gaussians of a ``.splat`` or, for any other suffix, ``.ply`` file, in float32.

    View-dependent colors (``f_rest_*``) are ignored. Raises SceneError: "file" if the file is unreadable or invalid,
    "backend" without torch; LimitError for more than MAX_GAUSSIANS.
    """
    target = Path(path)
    require("torch", INSTALL)
    try:
        if target.stat().st_size > _MAX_BYTES:
            raise LimitError("size", f"`{target}` is larger than {_MAX_BYTES:,} bytes")
        data = read_regular(target)
    except OSError as error:
        raise SceneError("file", f"cannot read {target}: {error.strerror or error}") from error
    return from_splat(data) if target.suffix.lower() == ".splat" else from_ply(data)


def from_splat(data: bytes) -> Gaussians:
    """Parse a ``.splat`` file; raises the errors of ``read_gaussians``."""
    count, rest = divmod(len(data), _SPLAT.itemsize)
    if rest:
        raise _invalid(f"expected a multiple of {_SPLAT.itemsize} bytes in a .splat file, found {rest} more")
    _check_count(count)
    rows = np.frombuffer(data, _SPLAT)
    scales = rows["scale"].astype(np.float64)
    if not (np.isfinite(scales) & (scales >= 0.0)).all():
        raise _invalid("a scale is negative or not finite")
    opacities = np.clip(rows["color"][:, 3] / 255.0, 1e-3, 1.0 - 1e-3)
    log_scales = np.log(np.maximum(scales, np.exp(-_MAX_LOG)))
    quaternions = (rows["rotation"].astype(np.float64) - 128.0) / 128.0
    logits = np.log(opacities / (1.0 - opacities))
    return _gaussians(rows["position"], log_scales, quaternions, logits, rows["color"][:, :3] / 255.0)


def from_ply(data: bytes) -> Gaussians:
    """Parse a ``.ply`` file; raises the errors of ``read_gaussians``."""
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
    """Layout of a ``.ply`` file: ``count`` rows of the type ``row`` from byte ``start`` on."""

    row: np.dtype[Any]
    count: int
    start: int


def _header(data: bytes) -> _Header:
    """Parse the header of a ``.ply`` file, and check it against the size of the file."""
    end = re.search(rb"\nend_header\r?\n", data[:_MAX_HEADER_BYTES])
    if not data.startswith(b"ply") or end is None:
        raise _invalid("it has no .ply header")
    lines = [line.split() for line in data[: end.start()].decode("ascii", "replace").splitlines()[1:]]
    lines = [words for words in lines if words and words[0] not in ("comment", "obj_info")]
    if not lines or lines[0] != ["format", "binary_little_endian", "1.0"]:
        raise _invalid("expected the format `binary_little_endian 1.0`")
    if len(lines) < 2 or lines[1][:2] != ["element", "vertex"] or len(lines[1]) != 3 or not _is_count(lines[1][2]):
        raise _invalid("expected `element vertex COUNT` as the first element")
    count, fields = int(lines[1][2]), _fields(lines[2:])
    _check_count(count)
    row = np.dtype(fields)
    if end.end() + count * row.itemsize > len(data):
        raise _invalid(f"it is truncated: the header specifies {count:,} Gaussians")
    return _Header(row, count, end.end())


def _fields(lines: list[list[str]]) -> list[tuple[str, str]]:
    """Parse the properties of the vertices to names with numpy types."""
    types: dict[str, str] = {}
    for words in lines:
        if words[0] != "property":
            break
        if len(words) != 3 or words[1] not in _TYPES or words[2] in types or len(types) >= _MAX_PROPERTIES:
            raise _invalid(f"unsupported property `{' '.join(words)[:60]}`")
        types[words[2]] = _TYPES[words[1]]
    missing = [name for name in _NAMES if name not in types and name not in _OPTIONAL]
    if missing:
        raise _invalid(f"missing property `{missing[0]}`")
    return list(types.items())


def _is_count(text: str) -> bool:
    return text.isascii() and text.isdigit() and len(text) < 12


def _check_count(count: int) -> None:
    if count > MAX_GAUSSIANS:
        raise LimitError("size", f"the file has {count:,} Gaussians, more than {MAX_GAUSSIANS:,}")


def _gaussians(
    means: npt.NDArray[Any], log_scales: FloatArray, quaternions: FloatArray, logits: FloatArray, srgb: FloatArray
) -> Gaussians:
    """Convert the columns of a file; raises SceneError("file") for values out of range."""
    import torch

    columns = {"position": means, "scale": log_scales, "rotation": quaternions, "opacity": logits, "color": srgb}
    for name, values in columns.items():
        if not (np.abs(values) < _MAX_VALUE).all():
            raise _invalid(f"the {name} of a Gaussian is not finite")
    if (np.abs(log_scales) > _MAX_LOG).any():
        raise _invalid("the scale of a Gaussian is out of range")
    if (np.linalg.norm(quaternions, axis=1) < 1e-6).any():
        raise _invalid("the quaternion of a Gaussian is zero")
    converted = (means, log_scales, quaternions, np.clip(logits, -_MAX_LOG, _MAX_LOG), from_srgb(srgb))
    return Gaussians(*(torch.from_numpy(np.array(column, np.float32)) for column in converted))


def _invalid(message: str) -> SceneError:
    return SceneError("file", f"not a valid file of Gaussians: {message}")
