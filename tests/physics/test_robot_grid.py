"""Every exported robot loads: extreme scenes of every primitive as MJCF and URDF in MuJoCo, once more after MuJoCo has
written them with its six digits, and as USD."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from extremes import EXTREMES, Extreme

import scenelang as sl

mujoco = pytest.importorskip("mujoco")
WATER = 1000.0  # kg/m^3, the density of a body without one


def _loads(path: Path, extreme: Extreme) -> Any:
    """The model of a file, whose bodies have positive inertias and together the mass of the scene."""
    assert "balanceinertia" not in path.read_text()
    model = mujoco.MjModel.from_xml_path(str(path))
    assert model.nbody == extreme.bodies + 1
    assert model.body_mass.sum() == pytest.approx(WATER * extreme.volume, rel=1e-3)
    assert (model.body_inertia[1:] > 0.0).all()
    return model


def _inertias(model: Any) -> np.ndarray:
    """The principal moments of each body, in order, as shares of the largest."""
    moments = np.sort(model.body_inertia[1:], axis=1)
    return np.asarray(moments / moments[:, 2:])


@pytest.mark.parametrize("ending", ["mjcf", "mjcf.xml", "urdf"])
@pytest.mark.parametrize("name", EXTREMES)
@pytest.mark.sampled(4)
def test_robots_load_and_load_again(name: str, ending: str, tmp_path: Path) -> None:
    extreme = EXTREMES[name]
    if not _is_exported(extreme, tmp_path / f"a.{ending}"):
        return
    model = first = _loads(tmp_path / f"a.{ending}", extreme)
    for again in ("b.xml", "c.xml"):
        mujoco.mj_saveLastXML(str(tmp_path / again), model)
        model = _loads(tmp_path / again, extreme)
    assert np.abs(_inertias(model) - _inertias(first)).max() < 1e-4
    data = mujoco.MjData(model)
    for _ in range(20):
        mujoco.mj_step(model, data)
    assert np.isfinite(data.qpos).all()


def _is_exported(extreme: Extreme, path: Path, **settings: Any) -> bool:
    """Write a scene; one may be refused whose body MuJoCo itself refuses."""
    try:
        sl.evaluate(extreme.text).export(path, settings=settings)
        return True
    except sl.SceneError as error:
        told = error.message
    assert "too light" in told
    assert not _may_weigh(WATER * extreme.volume / extreme.bodies, extreme.least, path.suffix)
    return False


def _may_weigh(mass: float, least: float, ending: str) -> bool:
    """Whether MuJoCo loads a body of a mass with a principal moment of ``least`` times it."""
    i = 1.01 * mass * least
    if ending == ".urdf":
        inertia = f'<inertia ixx="{i}" iyy="{i}" izz="{i}" ixy="0" ixz="0" iyz="0"/>'
        links = f'<link name="w"/><link name="a"><inertial><mass value="{mass}"/>{inertia}</inertial></link>'
        text = f'<robot name="r">{links}<joint name="j" type="floating"><parent link="w"/><child link="a"/></joint></robot>'
    else:
        own = f'<freejoint/><inertial pos="0 0 0" mass="{mass}" diaginertia="{i} {i} {i}"/>'
        text = f"<mujoco><worldbody><body>{own}</body></worldbody></mujoco>"
    try:
        mujoco.MjModel.from_xml_string(text)
    except ValueError:
        return False
    return True


def test_the_least_weight_is_that_of_mujoco() -> None:
    for ending in (".mjcf", ".urdf"):
        assert _may_weigh(1e-3, 1e-6, ending)
        assert not _may_weigh(1e-9, 1e-8, ending)


@pytest.mark.parametrize("name", EXTREMES)
@pytest.mark.sampled(4)
def test_usd_opens_with_every_body(name: str, tmp_path: Path) -> None:
    pytest.importorskip("pxr")
    from pxr import Usd, UsdPhysics, UsdValidation

    extreme = EXTREMES[name]
    if not _is_exported(extreme, tmp_path / "a.usda", physics=True):
        return
    stage = Usd.Stage.Open(str(tmp_path / "a.usda"))
    every = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    assert [error.GetMessage() for error in UsdValidation.ValidationContext(every).Validate(stage)] == []
    bodies = [UsdPhysics.MassAPI(prim) for prim in stage.Traverse() if prim.HasAPI(UsdPhysics.RigidBodyAPI)]
    assert len(bodies) == extreme.bodies
    masses = [body.GetMassAttr().Get() for body in bodies]
    assert sum(masses) == pytest.approx(WATER * extreme.volume, rel=1e-3)
    for body in bodies:
        moments = sorted(body.GetDiagonalInertiaAttr().Get())
        assert moments[0] > 0.0
        assert moments[0] + moments[1] >= (1.0 - 1e-6) * moments[2]  # in single precision
