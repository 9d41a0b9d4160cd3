"""MuJoCo models of bodies, and their motion under gravity.

Source: Todorov, Erez and Tassa, "MuJoCo: A physics engine for model-based control", IROS 2012. Scenes have y up, models
z up: a quarter turn about x. The frame of every body is at its center of mass, along the axes of the world, so that its
pose in the model is its motion. Lengths are meters, ``BodySet.unit`` of them per scene unit. A model is deterministic:
equal scenes give equal motions on one machine.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import Progress, require
from scenelang.backends.physics.colliders import INSTALL, Collider, FloatArray
from scenelang.backends.surfaces.appearance import look_of
from scenelang.backends.surfaces.image_files import to_srgb
from scenelang.backends.surfaces.trs import quaternions
from scenelang.grammar.diagnostics import LimitError, SceneError, suggest

if TYPE_CHECKING:
    from scenelang.backends.physics.grouping import BodySet, RigidBody

IntArray = npt.NDArray[np.int64]

GRAVITY = 9.81  # m/s^2
FRICTION = 0.6  # coefficient of bodies without `:friction`
MAX_SECONDS = 600.0  # of simulated time
MAX_STEPS = 400_000  # time steps of one simulation
MAX_SAMPLES = 20_000_000  # samples times bodies, whose poses are stored
_STEP_RANGE_S = (1 / 4000, 1 / 500)  # least and greatest time step
# of the time in which the smallest body falls by its own size: it cannot pass through another in one step
# of the time in which the smallest body falls by its own size, so that it moves little in a step
_STEP_FALL_RATIO = 0.02
_CONTACT_STEPS = 4.0  # time steps in which a contact is resolved; MuJoCo needs 2 or more
# Of contacts: the least and greatest impedance, and the depth in meters over which it grows. With MuJoCo's .9, .95 and
# .001 thin arches collapse that balance, also for ten times smaller time steps.
_CONTACT_IMPEDANCE = [0.98, 0.999, 0.0001, 0.5, 2.0]
_MIN_PIECE_M = 1e-9  # smaller pieces have no volume in MuJoCo's arithmetic
# in scene sizes: a simulation farther from the origin starts at the origin, because contacts lose digits
_MAX_OFFSET_SIZES = 100.0
_SUPPORT_STEPS = 5  # after which contacts are taken as the supports of the start; before, bodies still settle into them
_MIN_SUPPORT_NORMAL = 0.2  # vertical component of a contact's normal: a wall does not support leaning objects

# In MuJoCo 4.0 a cylinder that is upright up to rounding has false contacts with a plane: the plane's normal without
# its component along the axis is divided by its length, which is nearly zero. A tilt by a millionth avoids that.
_TILT = np.array([[1.0, 0.0, 1e-6], [0.0, 1.0, 0.0], [-1e-6, 0.0, 1.0]])

TO_MODEL = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])  # from y up to z up


class Distances:
    """Distances between objects made of convex colliders, measured by ``mj_geomDistance``.

    They are those of the colliders that move, not of our GJK on hulls: a ring and the object inside it touch as they do
    in the simulation.
    """

    def __init__(self, colliders: Sequence[Sequence[Collider]]) -> None:
        mujoco = require("mujoco", INSTALL)
        sizes = [float(np.linalg.norm(np.subtract(*shape.box()))) for group in colliders for shape in group]
        self.scale = 1.0 / float(np.median(sizes))
        spec = mujoco.MjSpec()
        meshes = _Meshes(mujoco, spec, self.scale)
        origin = colliders[0][0].center
        for group in colliders:
            for collider in group:
                if not _add_shape(mujoco, spec.worldbody, meshes, collider, origin, self.scale, {}):
                    # too small for MuJoCo's arithmetic: a point
                    place = TO_MODEL @ (collider.center - origin) * self.scale
                    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[_MIN_PIECE_M, 0, 0], pos=place)
        self.model, self.data = compiled(spec)
        mujoco.mj_forward(self.model, self.data)
        self.measure = mujoco.mj_geomDistance
        ends = np.cumsum([len(group) for group in colliders]).tolist()  # every collider is one geom
        self.geoms = [range(start, end) for start, end in zip([0, *ends[:-1]], ends)]

    def gaps(self, pairs: IntArray, margin: float) -> FloatArray:
        """Return the gap of each pair (M, 2) of objects, negative for a penetration; gaps are capped at ``margin``."""
        distances = [
            min(
                self.measure(self.model, self.data, a, b, margin * self.scale, None)
                for a in self.geoms[i]
                for b in self.geoms[j]
            )
            for i, j in pairs.tolist()
        ]
        return np.array(distances, np.float64) / self.scale

    def overlap(self, i: int, j: int) -> Overlap | None:
        """Return the deepest overlap of colliders of two objects, None if there is none."""
        return max(self.overlaps(i, j), key=lambda overlap: overlap.depth, default=None)

    def overlaps(self, i: int, j: int) -> Iterator[Overlap]:
        """Yield the overlaps of the colliders of two objects."""
        ends = np.zeros(6)
        for a, first in enumerate(self.geoms[i]):
            for b, second in enumerate(self.geoms[j]):
                depth = -self.measure(self.model, self.data, first, second, 0.0, ends)
                length = float(np.linalg.norm(ends[:3] - ends[3:]))
                if depth > 0.0 and length > 0.0:
                    yield Overlap(a, b, depth / self.scale, TO_MODEL.T @ (ends[:3] - ends[3:]) / length)


@dataclass(frozen=True, slots=True, eq=False)
class Overlap:
    """Overlap of two colliders.

    Attributes
    ----------
    first, second
        Numbers of the colliders in their objects.
    depth
        Penetration depth, in scene units.
    along : (3,)
        Unit vector in which the second collider leaves the first.
    """

    first: int
    second: int
    depth: float
    along: FloatArray


# --- models -----------------------------------------------------------------------------------------------------------


class _Meshes:
    """Meshes of a model; geoms with equal meshes share one."""

    def __init__(self, mujoco: Any, spec: Any, unit: float) -> None:
        self.mujoco, self.spec, self.unit = mujoco, spec, unit
        self.names: dict[bytes, str] = {}

    def name(self, vertices: FloatArray) -> str:
        """Return the name of the mesh with these corners, which is added on first use."""
        points = vertices @ TO_MODEL.T * self.unit
        # Equal meshes at several places differ in their last digits.
        key = (
            np.round(points / max(float(np.abs(points).max()), 1e-300), 9).tobytes()
            + repr(float(f"{np.abs(points).max():.9g}")).encode()
        )
        if key not in self.names:
            self.names[key] = f"piece{len(self.names)}"
            convex = self.mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX
            self.spec.add_mesh(name=self.names[key], uservert=points.ravel().tolist(), inertia=convex)
        return self.names[key]


def _add_shape(
    mujoco: Any, owner: Any, meshes: _Meshes, shape: Collider, origin: FloatArray, unit: float, look: Mapping[str, Any]
) -> bool:
    """Add a collider to the body ``owner`` whose frame is at ``origin``; return False if it is too small for MuJoCo."""
    low, high = shape.box()
    if float((high - low).max()) * unit <= _MIN_PIECE_M:
        return False
    kind = getattr(mujoco.mjtGeom, f"mjGEOM_{shape.kind.upper()}")
    rotation = TO_MODEL @ shape.rotation
    if shape.kind == "mesh":
        if _hull_volume(shape.vertices * unit) <= _MIN_PIECE_M**1.5:
            return False
        look = {**look, "meshname": meshes.name(shape.vertices)}
        rotation = rotation @ TO_MODEL.T  # the corners are in the frame of the model
    if shape.kind == "cylinder":
        rotation = rotation @ _TILT
    owner.add_geom(
        type=kind, size=(shape.size * unit).tolist(), pos=TO_MODEL @ (shape.center - origin) * unit,
        quat=quaternion(rotation), **look,
    )  # fmt: skip
    return True


def _hull_volume(points: FloatArray) -> float:
    """Return the volume of the box along the principal axes of points, an upper bound of their hull's."""
    centered = points - points.mean(axis=0)
    _, _, axes = np.linalg.svd(centered, full_matrices=False)
    return float(np.prod(np.ptp(centered @ axes.T, axis=0)))


def quaternion(rotation: FloatArray) -> list[float]:
    """Return a rotation (3, 3) as a unit quaternion w, x, y, z with w >= 0."""
    x, y, z, w = quaternions(rotation[None])[0].tolist()
    return [w, x, y, z]


def names_of(bodies: BodySet) -> list[str]:
    """Return a distinct name for each body: its word, reduced to letters, digits, dots and dashes, and its number."""
    return [
        f"{re.sub(r'[^A-Za-z0-9]+', '-', body.words[-1])[:40].strip('-') or 'body'}.{number}"
        for number, body in enumerate(bodies.bodies)
    ]


def model_of(bodies: BodySet, origin: FloatArray | None = None) -> Any:
    """Return a frame as a ``mujoco.MjSpec``: the ground, then the bodies in order, fixed ones without a joint.

    ``origin`` (3,) is the point of the scene that is the model's origin, by default that of the scene.
    """
    mujoco = require("mujoco", INSTALL)
    spec = mujoco.MjSpec()
    spec.modelname = "scene"
    spec.compiler.degree = False
    step = _time_step(bodies)
    spec.option.timestep = step
    spec.option.gravity = [0.0, 0.0, -GRAVITY]
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC  # the friction cone is round, as Coulomb's law has it
    # Bodies at rest on a slope do not creep: a box at 25 degrees moves .2 mm in 1.5 s, as with a ratio of 10 and four
    # noslip iterations (.3 mm without them), which took 95 % of the time of the chess set.
    spec.option.impratio = 100.0
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    look = {"solref": [_CONTACT_STEPS * step, 1.0], "solimp": _CONTACT_IMPEDANCE}
    height = bodies.ground * bodies.unit
    spec.worldbody.add_geom(
        name="ground", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0.0, 0.0, 1.0], pos=[0.0, 0.0, height],
        friction=[FRICTION, 0.0, 0.0], **look,
    )  # fmt: skip
    meshes = _Meshes(mujoco, spec, bodies.unit)
    for name, body in zip(names_of(bodies), bodies.bodies, strict=True):
        place = body.moments.center - (0.0 if origin is None else origin)
        _add_body(mujoco, spec, meshes, bodies, (body, name, place), look)
    return spec


_MIN_MASS = 1e-15  # in kg and kg m^2, the least that MuJoCo accepts
MIN_TENSOR = 1.1e-14  # in kg m^2: MuJoCo takes eigenvalues of an inertia tensor below 1e-14 (`mjEPS`) as zero


def check_weight(bodies: BodySet, body: RigidBody, least_inertia: float = _MIN_MASS) -> None:
    """Raise SceneError("physics") for a body that is too light to be simulated."""
    unit, moments = bodies.unit, body.moments
    least = float(moments.principal()[0].min()) * unit**2
    if not (moments.mass > _MIN_MASS and least > least_inertia and np.isfinite(moments.inertia).all()):
        message = f'"{body.name}" is too light to be simulated: {moments.mass:.3g} kg at {unit:.3g} metres per unit'
        raise SceneError("physics", message, "give a larger `--metres-per-unit`", span=bodies.place(body))


def _add_body(
    mujoco: Any, spec: Any, meshes: _Meshes, bodies: BodySet, placed: tuple[RigidBody, str, FloatArray],
    look: Mapping[str, Any],
) -> None:  # fmt: skip
    """Add a body with its joint, inertia and colliders to a model.

    ``placed`` is the body, its name, and its center of mass in scene units from the model's origin. Inertias are given,
    because those of MuJoCo's meshes count overlaps twice.
    """
    body, name, place = placed
    unit, moments = bodies.unit, body.moments
    inertia, axes = moments.principal()
    check_weight(bodies, body)
    owner = spec.worldbody.add_body(
        name=name,
        pos=TO_MODEL @ place * unit,
        mass=moments.mass,
        ipos=[0.0, 0.0, 0.0],
        iquat=quaternion(TO_MODEL @ axes),
        inertia=inertia * unit**2,
        explicitinertial=True,
    )
    if not body.fixed:
        owner.add_freejoint()
    for part in body.parts:
        friction = bodies.frictions[part]
        # MuJoCo takes the larger of two frictions, so that ice would not slide: one that is given has priority.
        attributes: dict[str, Any] = {
            "friction": [FRICTION if friction is None else friction, 0.0, 0.0],
            "priority": int(friction is not None),
        }
        attributes |= {"rgba": color_of(bodies, part), "mass": 0.0}
        for shape in bodies.parts[part].colliders:
            _add_shape(mujoco, owner, meshes, shape, moments.center, unit, {**look, **attributes})


def color_of(bodies: BodySet, part: int) -> list[float]:
    """Return the color of a part in sRGB, with its opacity."""
    look = look_of(bodies.nodes[bodies.parts[part].node].entity)
    rgb: list[float] = np.round(to_srgb(np.clip(look.color, 0.0, 1.0)), 4).tolist()
    return [*rgb, round(look.opacity, 4)]


def _time_step(bodies: BodySet) -> float:
    """Return the time step in seconds, by the size of the smallest movable body."""
    sizes = [body.size * bodies.unit for body in bodies.bodies if not body.fixed]
    fall = math.sqrt(min(sizes, default=1.0) / GRAVITY)
    return min(max(_STEP_FALL_RATIO * fall, _STEP_RANGE_S[0]), _STEP_RANGE_S[1])


def compiled(spec: Any) -> tuple[Any, Any]:
    """Return the ``MjModel`` and the ``MjData`` of a specification; raises SceneError("physics")."""
    mujoco = require("mujoco", INSTALL)
    try:
        model = spec.compile()
        return model, mujoco.MjData(model)
    except (ValueError, mujoco.FatalError) as error:
        reason = str(error).strip().splitlines()[0] if str(error).strip() else "no reason given"
        raise SceneError("physics", f"MuJoCo cannot simulate the scene: {reason}") from error


# --- motion -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """Motion of the bodies of a frame, T samples of N bodies, in the world of the scene.

    Attributes
    ----------
    times : (T,)
        Seconds from the start; the first is 0.
    centers : (T, N, 3)
        Centers of mass, in scene units.
    rotations : (T, N, 3, 3)
        Rotations since the start.
    speeds : (N,)
        Greatest speed of the center of mass, in scene units per second.
    supports
        For each body the points (K, 3), in scene units, at which something below touched it in the beginning, and the
        numbers of those bodies; -1 is the ground.
    landed
        For each body the numbers of those that touch it from below in the end.
    broken
        Number of the sample at which the simulation lost its numbers, None if it did not.
    launch
        Greatest initial speed, in scene units per second.
    """

    times: FloatArray
    centers: FloatArray
    rotations: FloatArray
    speeds: FloatArray
    supports: tuple[tuple[FloatArray, tuple[int, ...]], ...]
    landed: tuple[tuple[int, ...], ...]
    broken: int | None
    launch: float

    def pose(self, sample: int, body: int) -> FloatArray:
        """Return the motion (3, 4) of a body from its start to a sample, in the world of the scene."""
        rotation = self.rotations[sample, body]
        shift = self.centers[sample, body] - rotation @ self.centers[0, body]
        return np.column_stack([rotation, shift])


def simulate(
    bodies: BodySet,
    seconds: float = 1.5,
    rate: float = 60.0,
    velocities: Mapping[str, Sequence[float]] | None = None,
    progress: Progress | None = None,
) -> Motion:
    """Return the motion of the bodies of a frame under gravity.

    Parameters
    ----------
    bodies
        Bodies of a frame.
    seconds
        Simulated time.
    rate
        Samples per second.
    velocities
        Initial velocities by word, in scene units per second, of every body with that word on its path.
    progress
        Called with a fraction from 0 to 1; an exception that it raises ends the simulation.

    Raises
    ------
    SceneError
        "physics" if MuJoCo cannot simulate the scene, "value" for a velocity of an unknown word.
    LimitError
        "size" for too many steps or samples.
    """
    mujoco = require("mujoco", INSTALL)
    origin = _simulation_origin(bodies)
    model, data = compiled(model_of(bodies, origin))
    model.opt.disableflags |= int(
        mujoco.mjtDisableBit.mjDSBL_AUTORESET
    )  # a diverging simulation must be reported, not restarted
    joints = [int(model.body_dofadr[1 + number]) for number in range(len(bodies.bodies))]
    _start(bodies, data, joints, velocities or {})
    step = float(model.opt.timestep)
    samples = max(1, round(seconds * rate))
    steps_per_sample = max(1, round(1.0 / (rate * step)))
    model.opt.timestep = step = 1.0 / (rate * steps_per_sample)
    if (
        samples * steps_per_sample > MAX_STEPS
        or samples * len(joints) > MAX_SAMPLES
        or not 0.0 < seconds <= MAX_SECONDS
    ):
        limits = f"{MAX_SECONDS:g} s, {MAX_STEPS:,} steps and {MAX_SAMPLES:,} stored poses"
        message = f"{seconds:g} s of {len(joints):,} bodies are more than the limits of {limits}"
        raise LimitError("size", message, "simulate a shorter time")
    with _quiet(mujoco):
        try:
            motion = _run(
                mujoco, model, data, bodies, joints, (samples, steps_per_sample), progress or (lambda _: None)
            )
        except mujoco.FatalError as error:  # such as for contacts that exceed its memory
            message = f"{len(joints):,} bodies cannot be simulated: {error}"
            raise LimitError("size", message, "simulate fewer bodies, or a shorter time") from error
    supports = tuple((points + origin, below) for points, below in motion.supports)
    return replace(motion, centers=motion.centers + origin, supports=supports)


def _simulation_origin(bodies: BodySet) -> FloatArray:
    """Return the point (3,) that becomes the origin of the simulation.

    Far from the origin, the rounding errors of coordinates make contacts inaccurate. Bodies that are far away for their
    size are therefore simulated around the point on the level y = 0 below their center; others keep their origin, for
    which the result is zero.
    """
    if not bodies.bodies:
        return np.zeros(3)
    low = np.array([body.low for body in bodies.bodies]).min(axis=0)
    high = np.array([body.high for body in bodies.bodies]).max(axis=0)
    center = (low + high) / 2.0
    is_far = float(np.abs(center).max()) > _MAX_OFFSET_SIZES * float((high - low).max())
    return center * (1.0, 0.0, 1.0) if is_far else np.zeros(3)


def _start(bodies: BodySet, data: Any, joints: Sequence[int], velocities: Mapping[str, Sequence[float]]) -> None:
    """Set the initial velocities of the bodies; raises SceneError for an unknown word."""
    words = sorted({word for body in bodies.bodies if not body.fixed for word in body.words[1:] or body.words})
    for word, velocity in velocities.items():
        if word not in words:
            message = f'no body that can move has the word "{word}"'
            raise SceneError("value", message, suggest(word, words) or f"bodies: {', '.join(words[:8])}")
        for body, joint in zip(bodies.bodies, joints, strict=True):
            if word in body.words and joint >= 0:
                data.qvel[joint : joint + 3] = TO_MODEL @ np.asarray(velocity, np.float64) * bodies.unit


def _run(
    mujoco: Any, model: Any, data: Any, bodies: BodySet, joints: Sequence[int], plan: tuple[int, int], tell: Progress
) -> Motion:
    """Step a model and sample the poses of its bodies; ``plan`` is the number of samples and the steps of each.

    Supports are read once after ``_SUPPORT_STEPS`` steps, so the first samples may be stepped in two portions. A
    simulation whose numbers become invalid ends at that sample.
    """
    samples, steps_per_sample = plan
    count = len(joints)
    centers, turns = np.empty((samples + 1, count, 3)), np.empty((samples + 1, count, 3, 3))
    mujoco.mj_forward(model, data)
    supports: tuple[tuple[FloatArray, tuple[int, ...]], ...] = ()
    fastest = np.zeros(count)
    moving = np.array(joints) >= 0
    places = np.array(joints)[moving][:, None] + np.arange(3)
    launch = float(np.linalg.norm(data.qvel[places], axis=1).max(initial=0.0)) / bodies.unit
    broken: int | None = None
    done = 0
    for sample in range(samples + 1):
        if sample:
            first_steps = min(steps_per_sample, _SUPPORT_STEPS - done) if done < _SUPPORT_STEPS else 0
            if first_steps:
                mujoco.mj_step(model, data, first_steps)
            if not supports and done + first_steps >= _SUPPORT_STEPS:
                supports = _supports(mujoco, model, data, bodies)
            if steps_per_sample > first_steps:
                mujoco.mj_step(model, data, steps_per_sample - first_steps)
            done += steps_per_sample
            mujoco.mj_kinematics(model, data)
        centers[sample] = data.xpos[1:] @ TO_MODEL / bodies.unit
        turns[sample] = TO_MODEL.T @ data.xmat[1:].reshape(-1, 3, 3) @ TO_MODEL
        fastest[moving] = np.maximum(fastest[moving], np.linalg.norm(data.qvel[places], axis=1) / bodies.unit)
        if not np.isfinite(data.qpos).all() or not np.isfinite(data.qvel).all() or _lost(mujoco, data):
            broken = sample
            break
        tell(sample / samples)
    valid_samples = samples + 1 if broken is None else max(1, broken)
    times = np.arange(valid_samples, dtype=np.float64) * (steps_per_sample * float(model.opt.timestep))
    final_supports = _supports(mujoco, model, data, bodies)
    landed = tuple(below for _, below in final_supports)
    return Motion(
        times,
        centers[:valid_samples],
        turns[:valid_samples],
        fastest,
        supports or final_supports,
        landed,
        broken,
        launch,
    )


def _lost(mujoco: Any, data: Any) -> bool:
    """Return whether MuJoCo warned that its state is invalid; raises LimitError if its memory is too small."""
    kinds = mujoco.mjtWarning
    if data.warning[kinds.mjWARN_CONTACTFULL].number or data.warning[kinds.mjWARN_CNSTRFULL].number:
        raise LimitError("size", "too many contacts to be simulated", "simulate a part of the scene with `--root WORD`")
    bad = (kinds.mjWARN_BADQPOS, kinds.mjWARN_BADQVEL, kinds.mjWARN_BADQACC)
    return any(data.warning[kind].number for kind in bad)


def _supports(mujoco: Any, model: Any, data: Any, bodies: BodySet) -> tuple[tuple[FloatArray, tuple[int, ...]], ...]:
    """Return for each body the contact points from below, and the numbers of the bodies that they belong to."""
    contacts: list[list[FloatArray]] = [[] for _ in bodies.bodies]
    others: list[dict[int, None]] = [{} for _ in bodies.bodies]
    for contact in data.contact:
        normal = contact.frame[2]  # the height of the normal, from the first geom to the second
        if abs(normal) < _MIN_SUPPORT_NORMAL:
            continue
        lower, upper = contact.geom if normal > 0.0 else contact.geom[::-1]
        under, over = int(model.geom_bodyid[lower]) - 1, int(model.geom_bodyid[upper]) - 1
        if over >= 0 and over != under:
            contacts[over].append(TO_MODEL.T @ contact.pos / bodies.unit)
            others[over][under] = None
    return tuple(
        (np.array(points).reshape(-1, 3), tuple(below)) for points, below in zip(contacts, others, strict=True)
    )


@contextmanager
def _quiet(mujoco: Any) -> Iterator[None]:
    """Keep MuJoCo from writing a log file into the current folder; its warnings are counted in the data."""
    ignore: Callable[[str], None] = lambda _: None
    mujoco.set_mju_user_warning(ignore)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(None)
