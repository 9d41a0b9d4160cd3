"""Affine poses as translation, rotation and scale (TRS), the transforms that glTF and instancers have.

A pose with orthogonal axes is one node (t, R, S). A pose with shear is two by the singular value decomposition
A = U S V': a parent (t, U, S) and a child V'. The decomposition is unique up to signs (and the order of singular
values); in an animation each is chosen closest to that of the previous frame, so that interpolation takes the short
way.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import permutations, product

import numpy as np
import numpy.typing as npt

from scenelang.interpreter.values.values import Matrix

FloatArray = npt.NDArray[np.float64]

_MAX_COSINE = 1e-6  # between two axes of a pose without shear
_SIGNS = np.array([s for s in product((1.0, -1.0), repeat=3) if s[0] * s[1] * s[2] > 0.0])  # (4, 3) half turns


@dataclass(frozen=True, slots=True, eq=False)
class Decomposition:
    """Decomposition of P affine poses into TRS nodes.

    Attributes
    ----------
    translation, scale : (P, 3)
        Of the outer node, in scene units; negative scales mirror.
    rotation : (P, 4)
        Unit quaternion x y z w of the outer node.
    inner : (P, 4)
        Unit quaternion of the child node, the identity for poses without shear.
    shears : (P,)
        Whether a pose has shear.
    """

    translation: FloatArray
    rotation: FloatArray
    scale: FloatArray
    inner: FloatArray
    shears: npt.NDArray[np.bool_]


def decompose(poses: FloatArray) -> Decomposition:
    """Decompose each of the affine poses (P, 3, 4) independently."""
    linear = poses[:, :, :3]
    axes, size = _axes(linear)
    shears = _shears(axes)
    axes, size = _proper(_completed(axes, size > 0.0), size)
    inner = np.tile(np.eye(3), (len(poses), 1, 1))
    rows = np.flatnonzero(shears)
    if len(rows):
        axes[rows], size[rows], inner[rows] = singular(linear[rows])
    return Decomposition(poses[:, :, 3], quaternions(axes), size, quaternions(inner), shears)


def decompose_track(poses: FloatArray) -> Decomposition:
    """Decompose the poses (F, 3, 4) of one node over F frames, continuously from frame to frame."""
    linear = poses[:, :, :3]
    axes, size = _axes(linear)
    whole = size > 0.0
    if _shears(axes).any():
        outer, scale, inner = _continuous_singular(*singular(linear))
        shears = np.ones(len(poses), bool)
    else:
        outer, scale = _continuous(axes, size, whole)
        inner = np.tile(np.eye(3), (len(poses), 1, 1))
        shears = np.zeros(len(poses), bool)
    return Decomposition(
        poses[:, :, 3], _same_hemisphere(quaternions(outer)), scale, _same_hemisphere(quaternions(inner)), shears
    )


def unsheared(place: Matrix) -> tuple[Matrix, Matrix] | None:
    """Split a pose with shear into two without, whose product it is; None if it has no shear."""
    a, b, c, _, d, e, f, _, g, h, i, _ = place
    size = math.sqrt((a * a + d * d + g * g) * (b * b + e * e + h * h))
    other = math.sqrt((a * a + d * d + g * g) * (c * c + f * f + i * i))
    last = math.sqrt((b * b + e * e + h * h) * (c * c + f * f + i * i))
    bent = abs(a * b + d * e + g * h) > _MAX_COSINE * size or abs(a * c + d * f + g * i) > _MAX_COSINE * other
    if not bent and abs(b * c + e * f + h * i) <= _MAX_COSINE * last:
        return None
    matrix = np.array(place).reshape(3, 4)
    outer, scale, inner = singular(matrix[None, :, :3])
    first = np.hstack([outer[0] * scale[0], matrix[:, 3:]])
    return Matrix(first.ravel().tolist()), Matrix(np.hstack([inner[0], np.zeros((3, 1))]).ravel().tolist())


def quaternions(r: FloatArray) -> FloatArray:
    """Return the unit quaternions (P, 4), x y z w with w >= 0, of rotation matrices (P, 3, 3).

    Each row of 4 q q' is a multiple of q; the longest is used, which avoids the loss of precision near half turns
    (Shepperd, "Quaternion from Rotation Matrix", 1978).
    """
    x, y, z = r[:, 0, 0], r[:, 1, 1], r[:, 2, 2]
    a, b, c = r[:, 2, 1] - r[:, 1, 2], r[:, 0, 2] - r[:, 2, 0], r[:, 1, 0] - r[:, 0, 1]
    d, e, f = r[:, 0, 1] + r[:, 1, 0], r[:, 0, 2] + r[:, 2, 0], r[:, 1, 2] + r[:, 2, 1]
    rows = np.stack(
        [
            np.stack([1 + x - y - z, d, e, a], axis=1),
            np.stack([d, 1 - x + y - z, f, b], axis=1),
            np.stack([e, f, 1 - x - y + z, c], axis=1),
            np.stack([a, b, c, 1 + x + y + z], axis=1),
        ],
        axis=1,
    )
    longest = np.argmax(np.diagonal(rows, axis1=1, axis2=2), axis=1)
    q = rows[np.arange(len(r)), longest]
    q = q / np.linalg.norm(q, axis=1, keepdims=True)
    q = np.where((q[:, 3] < 0.0)[:, None], -q, q)
    exact: FloatArray = q + 0.0  # + 0.0 removes negative zeros
    return exact


# --- decomposition of single poses ---------------------------------------------------------------------------------


def _axes(linear: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the columns as unit vectors (P, 3, 3), zero vectors for zero length, and their lengths (P, 3)."""
    largest = np.abs(linear).max(axis=1)
    safe = np.where(largest > 0.0, largest, 1.0)
    scaled = linear / safe[:, None, :]
    size = np.sqrt((scaled * scaled).sum(axis=1))
    return scaled / np.where(size > 0.0, size, 1.0)[:, None, :], size * largest


def _shears(axes: FloatArray) -> npt.NDArray[np.bool_]:
    """Return which poses (P,) have axes that are not orthogonal."""
    products = np.abs(np.swapaxes(axes, 1, 2) @ axes)
    largest = np.maximum.reduce([products[:, 0, 1], products[:, 0, 2], products[:, 1, 2]])
    return np.asarray(largest > _MAX_COSINE, np.bool_)


def _completed(axes: FloatArray, whole: npt.NDArray[np.bool_], near: FloatArray | None = None) -> FloatArray:
    """Replace the zero columns of orthogonal axes (P, 3, 3), as close to the rotation ``near`` (3, 3) as possible."""
    axes = axes.copy()
    for row in np.flatnonzero(~whole.all(axis=1)):
        like = np.eye(3) if near is None else near
        known = [axes[row, :, k] for k in range(3) if whole[row, k]]
        for k in np.flatnonzero(~whole[row]):
            axes[row, :, k] = _orthogonal_to(known, like[:, k])
            known.append(axes[row, :, k])
    return axes


def _orthogonal_to(known: list[FloatArray], target: FloatArray) -> FloatArray:
    """Return the unit vector nearest to ``target`` that is orthogonal to all ``known`` unit vectors."""
    for candidate in (target, *np.eye(3)):
        rest = candidate - sum((v * (v @ candidate) for v in known), np.zeros(3))
        length = float(np.linalg.norm(rest))
        if length > 0.1:
            unit: FloatArray = rest / length
            return unit
    raise AssertionError("three axes span space")


def _proper(axes: FloatArray, size: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return proper rotations and scales, negating the x axis of left-handed frames."""
    axes, size = axes.copy(), size.copy()
    mirrored = np.linalg.det(axes) < 0.0
    axes[mirrored, :, 0] *= -1.0
    size[mirrored, 0] *= -1.0
    return axes, size


def singular(linear: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return rotations U, scales S and rotations V' with ``linear = U S V'``."""
    u, s, v = np.linalg.svd(linear)
    left, right = np.sign(np.linalg.det(u)), np.sign(np.linalg.det(v))
    return u * left[:, None, None], s * (left * right)[:, None], v * right[:, None, None]


# --- continuity over time ------------------------------------------------------------------------------------------


def _continuous(axes: FloatArray, size: FloatArray, whole: npt.NDArray[np.bool_]) -> tuple[FloatArray, FloatArray]:
    """Return continuous rotations and scales; the signs of scales change only where a pose is mirrored."""
    first = int(np.argmax(whole.sum(axis=1)))  # the frame with the most axes provides those missing in others
    base, length = _proper(_completed(axes[first][None], whole[first][None]), size[first][None])
    turned, scale = np.empty_like(axes), size.copy()
    for steps in (range(first, len(axes)), range(first - 1, -1, -1)):
        near, signs = base[0], np.where(length[0] < 0.0, -1.0, 1.0)
        for step in steps:
            near, signs = _nearest(axes[step], whole[step], near, signs)
            turned[step], scale[step] = near, size[step] * signs
    return turned, scale


def _nearest(
    axes: FloatArray, whole: npt.NDArray[np.bool_], near: FloatArray, signs: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the rotation and the signs of the scale of ``axes`` (3, 3) that are closest to ``near`` and ``signs``.

    ``whole`` (3,) marks axes of nonzero length.
    """
    if not whole.all():
        full = _completed((axes * signs)[None], whole[None], near)[0]
        if np.linalg.det(full) < 0.0:
            full[:, int(np.argmin(whole))] *= -1.0  # its scale is 0
        return full, signs
    if np.linalg.det(axes) * np.prod(signs) < 0.0:
        choices = -signs * _SIGNS
        signs = choices[np.argmax(np.einsum("ij,ij,sj->s", near, axes, choices))]
    return axes * signs, signs


def _continuous_singular(u: FloatArray, s: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Reorder and flip singular values so that each frame is closest to the one before; products stay the same.

    There are six orders and four sign patterns that keep U and V' rotations; all are compared.
    """
    u, s, v = u.copy(), s.copy(), v.copy()
    orders = np.array(list(permutations(range(3))))
    odd = np.array([np.linalg.det(np.eye(3)[order]) for order in orders])[:, None, None]
    signs = np.where(s[0] < 0.0, -1.0, 1.0)
    for step in range(1, len(u)):
        us = u[step][:, orders].transpose(1, 0, 2) * odd  # (6, 3, 3) columns in each order, made proper
        vs = v[step][orders] * odd  # (6, 3, 3) rows in each order
        length = s[step][orders]
        current = np.where(length < 0.0, -1.0, 1.0)
        mirrored = bool((current[0].prod() != signs.prod()) and length[0].all())
        signs = -signs if mirrored else signs
        us, length = us * (current * signs)[:, None, :], np.abs(length) * signs
        proper = np.linalg.det(us) > 0.0
        us = np.where(proper[:, None, None], us, -us)  # only where a singular value is 0
        length = np.where(proper[:, None], length, -length)
        near = np.einsum("ij,oij,sj->os", u[step - 1], us, _SIGNS) + np.einsum("ij,oij,si->os", v[step - 1], vs, _SIGNS)
        change = np.abs(length - s[step - 1]).sum(axis=1) / max(float(np.abs(s[step - 1 : step + 1]).max()), 1e-300)
        near -= 6.0 * change[:, None]  # prefer solutions in which a rotating object keeps its scale
        order, flip = np.unravel_index(int(np.argmax(near)), near.shape)
        u[step], v[step] = us[order] * _SIGNS[flip], vs[order] * _SIGNS[flip][:, None]
        s[step] = length[order]
    return u, s, v


def _same_hemisphere(q: FloatArray) -> FloatArray:
    """Flip quaternions (P, 4) so that consecutive ones are in the same hemisphere, between which slerp is short."""
    if len(q) < 2:
        return q
    turned = np.cumprod(np.concatenate([[1.0], np.where((q[1:] * q[:-1]).sum(axis=1) < 0.0, -1.0, 1.0)]))
    out: FloatArray = q * turned[:, None] + 0.0
    return out
