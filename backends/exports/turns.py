"""Affine poses as translation, rotation and scale, which is all that a glTF node can say, also over time.

A pose whose axes stay square is one node (t, R, S). One that shears is two by the singular value decomposition
A = U S V': a parent (t, U, S) and a child V'. A decomposition is unique but for signs (and the order of singular
values); over the frames of an animation each is chosen next to the one before, so that what lies between two frames is
a short way.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import permutations, product
from typing import Any

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]

_SQUARE = 1e-6  # cosine between two axes of a pose below which it does not shear
_SIGNS = np.array([s for s in product((1.0, -1.0), repeat=3) if s[0] * s[1] * s[2] > 0.0])  # (4, 3) half turns


@dataclass(frozen=True, slots=True, eq=False)
class Turns:
    """P poses: ``translation`` (P, 3), ``rotation`` (P, 4) unit quaternions x y z w, ``scale`` (P, 3) and, for those
    that shear, ``inner`` (P, 4), the quaternion of the child node; ``shears`` (P,) says where it is needed."""

    translation: FloatArray
    rotation: FloatArray
    scale: FloatArray
    inner: FloatArray
    shears: npt.NDArray[np.bool_]


def turns_of(poses: FloatArray) -> Turns:
    """The decomposition of each of the affine poses (P, 3, 4) on its own."""
    linear = poses[:, :, :3]
    axes, size = _axes(linear)
    shears = _shears(axes)
    axes, size = _proper(_completed(axes, size > 0.0), size)
    inner = np.tile(np.eye(3), (len(poses), 1, 1))
    rows = np.flatnonzero(shears)
    if len(rows):
        axes[rows], size[rows], inner[rows] = _singular(linear[rows])
    return Turns(poses[:, :, 3], quaternions(axes), size, quaternions(inner), shears)


def track_of(poses: FloatArray) -> Turns:
    """The decomposition of the poses (F, 3, 4) of one node over F frames: all of one kind, each next to the last."""
    linear = poses[:, :, :3]
    axes, size = _axes(linear)
    whole = size > 0.0
    if _shears(axes).any():
        outer, scale, inner = _followed_singular(*_singular(linear))
        shears = np.ones(len(poses), bool)
    else:
        outer, scale = _followed(axes, size, whole)
        inner = np.tile(np.eye(3), (len(poses), 1, 1))
        shears = np.zeros(len(poses), bool)
    return Turns(poses[:, :, 3], _same_side(quaternions(outer)), scale, _same_side(quaternions(inner)), shears)


def node_fields(turns: Turns, index: int) -> list[dict[str, Any]]:
    """The fields of one glTF node, or of a parent and its child, for pose ``index``; what is identity is left out."""
    fields = {"translation": turns.translation, "rotation": turns.rotation, "scale": turns.scale}
    neutral = {"translation": [0.0, 0.0, 0.0], "rotation": [0.0, 0.0, 0.0, 1.0], "scale": [1.0, 1.0, 1.0]}
    listed = {name: values[index].tolist() for name, values in fields.items()}
    outer = {name: value for name, value in listed.items() if value != neutral[name]}
    return [outer, {"rotation": turns.inner[index].tolist()}] if turns.shears[index] else [outer]


def quaternions(r: FloatArray) -> FloatArray:
    """The unit quaternions (P, 4), x y z w, of rotation matrices (P, 3, 3): the longest row of 4 q q'."""
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
    exact: FloatArray = q + 0.0  # no negative zeros
    return exact


# --- one pose --------------------------------------------------------------------------------------------------


def _axes(linear: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The columns as unit vectors (P, 3, 3), zero where they have no length, and their lengths (P, 3)."""
    largest = np.abs(linear).max(axis=1)
    safe = np.where(largest > 0.0, largest, 1.0)
    scaled = linear / safe[:, None, :]
    size = np.sqrt((scaled * scaled).sum(axis=1))
    return scaled / np.where(size > 0.0, size, 1.0)[:, None, :], size * largest


def _shears(axes: FloatArray) -> npt.NDArray[np.bool_]:
    products = np.abs(np.swapaxes(axes, 1, 2) @ axes)
    bent: npt.NDArray[np.bool_] = np.maximum.reduce([products[:, 0, 1], products[:, 0, 2], products[:, 1, 2]]) > _SQUARE
    return bent


def _completed(axes: FloatArray, whole: npt.NDArray[np.bool_], near: FloatArray | None = None) -> FloatArray:
    """Square axes (P, 3, 3) whose zero columns are replaced, as near to the rotation ``near`` as may be."""
    axes = axes.copy()
    for row in np.flatnonzero(~whole.all(axis=1)):
        like = np.eye(3) if near is None else near
        known = [axes[row, :, k] for k in range(3) if whole[row, k]]
        for k in np.flatnonzero(~whole[row]):
            axes[row, :, k] = _across(known, like[:, k])
            known.append(axes[row, :, k])
    return axes


def _across(known: list[FloatArray], wanted: FloatArray) -> FloatArray:
    """The unit vector nearest to ``wanted`` that is square to all ``known`` unit vectors."""
    for candidate in (wanted, *np.eye(3)):
        rest = candidate - sum((v * (v @ candidate) for v in known), np.zeros(3))
        length = float(np.linalg.norm(rest))
        if length > 0.1:
            unit: FloatArray = rest / length
            return unit
    raise AssertionError("three axes span space")


def _proper(axes: FloatArray, size: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Rotations and scales: the x axis turned round where the axes are left-handed."""
    axes, size = axes.copy(), size.copy()
    mirrored = np.linalg.det(axes) < 0.0
    axes[mirrored, :, 0] *= -1.0
    size[mirrored, 0] *= -1.0
    return axes, size


def _singular(linear: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Rotations U, scales S and rotations V' with ``linear = U S V'``."""
    u, s, v = np.linalg.svd(linear)
    left, right = np.sign(np.linalg.det(u)), np.sign(np.linalg.det(v))
    return u * left[:, None, None], s * (left * right)[:, None], v * right[:, None, None]


# --- over time -------------------------------------------------------------------------------------------------


def _followed(axes: FloatArray, size: FloatArray, whole: npt.NDArray[np.bool_]) -> tuple[FloatArray, FloatArray]:
    """Rotations and scales; the signs of the scales change only where a pose becomes its mirror image."""
    first = int(np.argmax(whole.sum(axis=1)))  # the frame that says most gives the others their missing axes
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
    """The rotation, and the signs of the scale, that continue ``near`` and ``signs`` to the square ``axes`` (3, 3)."""
    if not whole.all():
        full = _completed((axes * signs)[None], whole[None], near)[0]
        if np.linalg.det(full) < 0.0:
            full[:, int(np.argmin(whole))] *= -1.0  # its scale is 0
        return full, signs
    if np.linalg.det(axes) * np.prod(signs) < 0.0:
        choices = -signs * _SIGNS
        signs = choices[np.argmax(np.einsum("ij,ij,sj->s", near, axes, choices))]
    return axes * signs, signs


def _followed_singular(u: FloatArray, s: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The same products with order and signs of the singular values that follow from frame to frame."""
    u, s, v = u.copy(), s.copy(), v.copy()
    orders = np.array(list(permutations(range(3))))
    odd = np.array([np.linalg.det(np.eye(3)[order]) for order in orders])[:, None, None]
    signs = np.where(s[0] < 0.0, -1.0, 1.0)
    for step in range(1, len(u)):
        us = u[step][:, orders].transpose(1, 0, 2) * odd  # (6, 3, 3) columns in each order, proper again
        vs = v[step][orders] * odd  # (6, 3, 3) rows in each order
        length = s[step][orders]
        own = np.where(length < 0.0, -1.0, 1.0)
        mirrored = bool((own[0].prod() != signs.prod()) and length[0].all())
        signs = -signs if mirrored else signs
        us, length = us * (own * signs)[:, None, :], np.abs(length) * signs
        proper = np.linalg.det(us) > 0.0
        us = np.where(proper[:, None, None], us, -us)  # only where a singular value is 0
        length = np.where(proper[:, None], length, -length)
        near = np.einsum("ij,oij,sj->os", u[step - 1], us, _SIGNS) + np.einsum("ij,oij,si->os", v[step - 1], vs, _SIGNS)
        change = np.abs(length - s[step - 1]).sum(axis=1) / max(float(np.abs(s[step - 1 : step + 1]).max()), 1e-300)
        near -= 6.0 * change[:, None]  # a thing that turns keeps its size
        order, flip = np.unravel_index(int(np.argmax(near)), near.shape)
        u[step], v[step] = us[order] * _SIGNS[flip], vs[order] * _SIGNS[flip][:, None]
        s[step] = length[order]
    return u, s, v


def _same_side(q: FloatArray) -> FloatArray:
    """Quaternions whose signs follow from frame to frame."""
    if len(q) < 2:
        return q
    turned = np.cumprod(np.concatenate([[1.0], np.where((q[1:] * q[:-1]).sum(axis=1) < 0.0, -1.0, 1.0)]))
    out: FloatArray = q * turned[:, None] + 0.0
    return out
