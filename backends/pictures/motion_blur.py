"""Motion blur: an image of the time while a shutter is open, the mean of sharp images at instants between frames.

Between two frames of a scene, objects move along the poses that their entities have in both; an entity that is made
differently in the next frame stays as it is. Renderers have no part in it: each instant is a frame of its own.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import Progress, sub_progress
from scenelang.backends.pictures.camera import Camera
from scenelang.backends.pictures.declared import share_of
from scenelang.backends.pictures.painted import Image, Painter
from scenelang.backends.pictures.stage import Shot, Staging
from scenelang.backends.surfaces.environments import tone_map
from scenelang.backends.surfaces.image_files import encode, from_srgb
from scenelang.interpreter.scene.entity import Entity, Scene, pose_of
from scenelang.interpreter.values.values import Pair

FloatArray = npt.NDArray[np.float64]

INSTANTS = 16  # of an image; with 8, objects that move by a tenth of its width were seen as steps


def instants_of(scene: Scene, shots: Sequence[Shot], shutter: float) -> tuple[Scene, list[list[Shot]]]:
    """Return the scene with the instants of images as further frames, and the instants of each of the ``shots``.

    The shutter opens at the shot and stays open for a share of the time to the next one; after the last one, objects
    go on as they came. A single shot is followed by the next frame of the scene.

    Parameters
    ----------
    shutter
        Share of the time between two images, from 0 to 1.
    """
    shares = [shutter * (k + 0.5) / INSTANTS for k in range(INSTANTS)]
    frames = list(scene.frames)
    known: dict[tuple[int, int, float], list[int]] = {}
    instants = []
    for k, shot in enumerate(shots):
        first, last, start = _motion(scene, shots, k)
        times, key = [start + share for share in shares], (first.frame, last.frame, start)
        if key not in known:
            between = list(entities_between(scene.frames[first.frame], scene.frames[last.frame], times))
            is_still = all(entity is scene.frames[first.frame] for entity in between)
            known[key] = [shot.frame] * INSTANTS if is_still else list(range(len(frames), len(frames) + INSTANTS))
            frames += [] if is_still else between
        cameras = [camera_between(first.camera, last.camera, time) for time in times]
        passed = [first.share + (last.share - first.share) * time for time in times]
        numbers = [(number, INSTANTS) for number in range(INSTANTS)]
        instants.append([Shot(*each) for each in zip(known[key], cameras, passed, numbers, strict=True)])
    return scene.with_frames(frames), instants


def _motion(scene: Scene, shots: Sequence[Shot], k: int) -> tuple[Shot, Shot, float]:
    """Return the two shots by which objects move at shot ``k``, and its time: 0 for the first of them, else 1."""
    shot = shots[k]
    if k + 1 < len(shots):
        return shot, shots[k + 1], 0.0
    if k > 0:
        return shots[k - 1], shot, 1.0
    if shot.frame + 1 < len(scene.frames):
        return shot, _next_to(scene, shot, 1), 0.0
    return (_next_to(scene, shot, -1), shot, 1.0) if shot.frame > 0 else (shot, shot, 0.0)


def _next_to(scene: Scene, shot: Shot, step: int) -> Shot:
    """Return the shot of another frame by the same camera."""
    return replace(shot, frame=shot.frame + step, share=share_of(scene, shot.frame + step))


def entities_between(one: Entity, other: Entity, times: Sequence[float]) -> Iterator[Entity]:
    """Yield an entity at ``times``, 0 as it is in one frame and 1 in another; other times go on in the same way."""
    order = list(_pairs(one, other))
    moved = [(pose_of(a), pose_of(b)) for node, to in order for a, b in zip(node.children, to.children, strict=True)]
    track = _poses_between(np.array(moved).reshape(-1, 2, 3, 4), times)
    for k in range(len(times)):
        made: dict[tuple[int, int], Entity] = {}
        poses = iter(track[k].reshape(-1, 12).tolist())
        for node, to in order:
            children, is_same = [], True
            for a, b in zip(node.children, to.children, strict=True):
                child = made.get((id(a.car), id(b.car)), a.car)
                pose: Any = tuple(next(poses))
                is_same = is_same and child is a.car and pose_of(a) == pose_of(b)
                children.append(Pair(child, pose))
            made[id(node), id(to)] = node if is_same else _with_children(node, tuple(children))
        yield made.get((id(one), id(other)), one)


def _with_children(entity: Entity, children: tuple[Pair, ...]) -> Entity:
    """Return an entity with other children."""
    return Entity(entity.word, entity.embedding, children, None, entity.tainted, entity.call_sites)


def _pairs(one: Entity, other: Entity) -> Iterator[tuple[Entity, Entity]]:
    """Yield pairs of entities of two frames that correspond and differ, children before parents."""
    seen: set[tuple[int, int]] = set()
    stack = [(one, other, False)]
    while stack:
        node, to, is_done = stack.pop()
        if is_done:
            yield node, to
        elif node is not to and (id(node), id(to)) not in seen and _corresponds(node, to):
            seen.add((id(node), id(to)))
            stack.append((node, to, True))
            stack += [(a.car, b.car, False) for a, b in zip(node.children, to.children, strict=True)]


def _corresponds(node: Entity, to: Entity) -> bool:
    """Return whether two entities have the same word and as many parts."""
    return node.word == to.word and node.shape is None and to.shape is None and len(node.children) == len(to.children)


def _poses_between(pairs: FloatArray, times: Sequence[float]) -> FloatArray:
    """Return the poses (T, P, 3, 4) at times between pairs of poses (P, 2, 3, 4).

    The motion from the first pose to the second is a rotation about the pose's origin by a growing angle, after a
    stretch that grows linearly (polar decomposition); places move on straight lines. A motion without a rotation, such
    as a reflection or that of a singular pose, is linear.
    """
    start, end = pairs[:, 0], pairs[:, 1]
    with np.errstate(all="ignore"):
        is_regular = np.abs(np.linalg.det(start[:, :, :3])) > 0.0
        safe = np.where(is_regular[:, None, None], start[:, :, :3], np.eye(3))
        change = end[:, :, :3] @ np.linalg.inv(safe)
    is_regular &= np.isfinite(change).all(axis=(1, 2)) & (np.linalg.det(np.nan_to_num(change)) > 0.0)
    u, sizes, v = np.linalg.svd(np.where(is_regular[:, None, None], change, np.eye(3)))
    stretch = np.swapaxes(v, 1, 2) @ (sizes[:, :, None] * v)
    axis, angle = _axis_and_angle(u @ v)
    out = np.empty((len(times), *start.shape))
    for k, time in enumerate(times):
        out[k] = start + (end - start) * time
        turned = _rotations(axis, angle * time) @ (np.eye(3) + (stretch - np.eye(3)) * time) @ start[:, :, :3]
        out[k, is_regular, :, :3] = turned[is_regular]
    return out


def _axis_and_angle(rotations: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the unit axes (P, 3) and the angles (P,) of rotations (P, 3, 3); half turns have one of two axes."""
    cosine = np.clip((np.trace(rotations, axis1=1, axis2=2) - 1.0) / 2.0, -1.0, 1.0)
    skew = np.stack([
        rotations[:, 2, 1] - rotations[:, 1, 2], rotations[:, 0, 2] - rotations[:, 2, 0],
        rotations[:, 1, 0] - rotations[:, 0, 1],
    ], axis=1)  # fmt: skip
    sine = np.linalg.norm(skew, axis=1)
    is_half = (sine < 1e-9) & (cosine < 0.0)
    if is_half.any():  # the axis is the eigenvector of 1: a column of R + 1
        column = (rotations + np.eye(3))[is_half]
        longest = np.linalg.norm(column, axis=1).argmax(axis=1)
        skew[is_half] = np.take_along_axis(column, longest[:, None, None], axis=2)[:, :, 0]
    length = np.linalg.norm(skew, axis=1)
    axis = np.where(length[:, None] > 0.0, skew / np.maximum(length, 1e-300)[:, None], [0.0, 1.0, 0.0])
    return axis, np.arctan2(sine / 2.0, cosine)


def _rotations(axis: FloatArray, angle: FloatArray) -> FloatArray:
    """Return the rotations (P, 3, 3) about unit axes (P, 3) by angles (P,) (Rodrigues' formula)."""
    cross = np.zeros((len(axis), 3, 3))
    for row, column, part in ((2, 1, 0), (0, 2, 1), (1, 0, 2)):
        cross[:, row, column], cross[:, column, row] = axis[:, part], -axis[:, part]
    sine, rest = np.sin(angle)[:, None, None], (1.0 - np.cos(angle))[:, None, None]
    return np.asarray(np.eye(3) + sine * cross + rest * (cross @ cross), np.float64)


def camera_between(one: Camera, other: Camera, time: float) -> Camera:
    """Return a camera on the way from one to another of the same kind and size: the eye on a straight line."""
    if one is other:
        return one
    inverse = np.stack([np.linalg.inv(camera.world_to_camera)[:3] for camera in (one, other)])
    pose = np.vstack([_poses_between(inverse[None], [time])[0, 0], [0.0, 0.0, 0.0, 1.0]])
    intrinsics = one.intrinsics + (other.intrinsics - one.intrinsics) * time
    return replace(
        one,
        world_to_camera=np.linalg.inv(pose),
        intrinsics=intrinsics,
        focus=one.focus + (other.focus - one.focus) * time,
    )


class BlurPainter:
    """Draws shots as the means of their instants; see ``Painter``."""

    def __init__(
        self, painter: Painter, staging: Staging, shots: Sequence[Shot], instants: Sequence[Sequence[Shot]]
    ) -> None:
        """Blur the ``shots`` over their ``instants``, which ``painter`` draws; both have frames of ``staging``."""
        self._painter, self._staging = painter, staging
        self._instants = {id(shot): each for shot, each in zip(shots, instants, strict=True)}
        self._shots = tuple(shots)  # which keeps their numbers alive

    def paint(self, shot: Shot, progress: Progress | None = None) -> Image:
        """Draw one shot; light is added up before the tone curve, as on a sensor, where an image is opaque."""
        instants = self._instants[id(shot)]
        images = [
            self._painter.paint(instant, sub_progress(progress, k / len(instants), (k + 1) / len(instants)))
            for k, instant in enumerate(instants)
        ]
        radiance = np.asarray(np.mean([image.radiance for image in images], axis=0), np.float32)
        if images[0].alpha is None:
            environment = self._staging.stage(instants[0]).studio.environment
            return Image(encode(tone_map(radiance, environment)), radiance)
        alpha = np.mean([image.rgba[:, :, 3] for image in images], axis=0)
        light = np.mean([from_srgb(i.picture / 255.0) * i.rgba[:, :, 3:] for i in images], axis=0)
        picture = encode(light / np.maximum(alpha, 1e-6)[:, :, None])
        return Image(picture, radiance, np.asarray(np.rint(alpha), np.uint8))
