"""Files of Gaussians: read back as written, by an independent reader too; wrong files are refused in one line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from later import later
from searching import many
from support import evaluate

from scenelang.backends.base import BackendOptions, find
from scenelang.backends.neural.splats.files import (
    C0,
    MAX_GAUSSIANS,
    from_ply,
    from_splat,
    ply_rows,
    read_gaussians,
    splat_rows,
    write_gaussians,
)
from scenelang.backends.neural.splats.gaussians import Gaussians
from scenelang.grammar.diagnostics import LimitError, SceneError
from splats.drawing import random_gaussians

torch = later("torch")

HEADER = "ply\nformat binary_little_endian 1.0\nelement vertex {count}\n{properties}end_header\n"
PROPERTIES = ["x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2"]
PROPERTIES += ["rot_0", "rot_1", "rot_2", "rot_3"]


def ply(count: object = 1, names: list[str] = PROPERTIES, kind: str = "float", body: bytes | None = None) -> bytes:
    properties = "".join(f"property {kind} {name}\n" for name in names)
    row = np.full(len(names), 0.5, np.float32).tobytes()
    return HEADER.format(count=count, properties=properties).encode() + (row if body is None else body)


@settings(deadline=None, max_examples=many(25), suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.integers(0, 2**31), st.integers(0, 30))
def test_a_ply_is_read_back(tmp_path: Path, seed: int, count: int) -> None:
    one = random_gaussians(count, seed, dtype=torch.float32)
    write_gaussians(one, tmp_path / "a.ply")
    again = read_gaussians(tmp_path / "a.ply")
    for name in ("means", "log_scales", "opacity_logits"):
        assert getattr(again, name).equal(getattr(one, name))
    torch.testing.assert_close(again.colors, one.colors, atol=1e-6, rtol=1e-5)
    torch.testing.assert_close(again.covariances, one.covariances)


@settings(deadline=None, max_examples=many(25), suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.integers(0, 2**31), st.integers(0, 30))
def test_a_splat_is_read_back_as_its_8_bits_allow(tmp_path: Path, seed: int, count: int) -> None:
    one = random_gaussians(count, seed, dtype=torch.float32)
    path = tmp_path / "a.splat"
    write_gaussians(one, path)
    assert path.stat().st_size == 32 * count
    again = read_gaussians(path)
    order = (-one.log_scales.double().sum(1).exp() * one.opacities.double()).sort(stable=True).indices
    one = one.take(order)
    if count:
        assert (again.means[:, 0].sort().values - one.means[:, 0].sort().values).abs().max() == 0.0
        away = torch.cdist(again.means, one.means)
        nearest = away.argmin(1)
        one = one.take(nearest)
        torch.testing.assert_close(again.log_scales, one.log_scales, atol=1e-5, rtol=1e-5)
        assert (again.opacities - one.opacities).abs().max() < 4e-3
        size = one.log_scales.exp().amax(1)[:, None, None]
        assert ((again.covariances - one.covariances).abs() / size**2).max() < 0.05
        assert (
            torch.from_numpy(np.abs(again.colors.numpy() ** (1 / 2.2) - one.colors.numpy() ** (1 / 2.2)))
        ).max() < 0.02


def test_bytes_of_one_splat_by_hand() -> None:
    one = Gaussians(
        torch.tensor([[1.0, 2.0, 3.0]]),
        torch.tensor([[0.5, 1.0, 2.0]]).log(),
        torch.tensor([[2.0, 0.0, 0.0, 0.0]]),
        torch.tensor([0.0]),
        torch.tensor([[1.0, 0.0, 0.2140411]]),
    )
    floats = np.array([1.0, 2.0, 3.0, 0.5, 1.0, 2.0], "<f4").tobytes()
    assert splat_rows(one).tobytes() == floats + bytes([255, 0, 127, 128]) + bytes([255, 128, 128, 128])
    row = ply_rows(one)[0]
    np.testing.assert_allclose(row[6:10], [0.5 / C0, -0.5 / C0, 0.0, 0.0], atol=1e-4)
    np.testing.assert_allclose(row[10:], [*np.log([0.5, 1.0, 2.0]), 1.0, 0.0, 0.0, 0.0], atol=1e-6)


def test_another_package_reads_the_ply(tmp_path: Path) -> None:
    trimesh = pytest.importorskip("trimesh")
    one = random_gaussians(7, dtype=torch.float32)
    write_gaussians(one, tmp_path / "a.ply")
    cloud = trimesh.load(tmp_path / "a.ply")
    np.testing.assert_array_equal(np.asarray(cloud.vertices, np.float32), one.means.numpy())
    rows = cloud.metadata["_ply_raw"]["vertex"]["data"]
    np.testing.assert_array_equal(np.asarray(rows["opacity"]).ravel(), one.opacity_logits.numpy())
    np.testing.assert_array_equal(np.asarray(rows["scale_2"]).ravel(), one.log_scales[:, 2].numpy())


def test_files_of_other_programs_are_read() -> None:
    """Properties in any order and of any type, with higher harmonics, comments, carriage returns, later elements."""
    names = ["rot_3", "f_rest_0", *PROPERTIES[:-1]]
    body = np.full(len(names), 0.5, "<f8").tobytes()
    data = ply(1, names, "double", body + b"\x00" * 5)
    data = data.replace(b"end_header", b"element face 5\nproperty uchar k\nend_header")
    data = data.replace(b"element vertex", b"comment x\nelement vertex", 1)
    found = from_ply(data)
    assert found.means.tolist() == [[0.5, 0.5, 0.5]]
    head, _, body = data.partition(b"end_header\n")
    assert len(from_ply(head.replace(b"\n", b"\r\n") + b"end_header\r\n" + body)) == 1


NAN = np.full(len(PROPERTIES), np.nan, np.float32).tobytes()
WRONG = {
    "empty": b"",
    "no header": b"ply\n" + b"x" * 100,
    "no end": HEADER.encode()[:40],
    "text": ply().replace(b"binary_little_endian", b"ascii"),
    "big": ply().replace(b"little", b"big"),
    "a mesh": ply(names=["x", "y", "z"]),
    "short": ply(2),
    "negative": ply(-1),
    "no count": ply("many"),
    "digits": ply("²"),
    "list": ply().replace(b"property float x", b"property list uchar float x"),
    "twice": ply(names=[*PROPERTIES, "x"]),
    "unknown type": ply(kind="quad"),
    "no numbers": ply(body=NAN),
    "far": ply(body=np.full(len(PROPERTIES), 3e38, np.float32).tobytes()),
    "large": ply(body=np.full(len(PROPERTIES), 100.0, np.float32).tobytes()),
    "no turn": ply(body=np.zeros(len(PROPERTIES), np.float32).tobytes()),
    "too many properties": ply(names=[*PROPERTIES, *(f"a{i}" for i in range(3_000))]),
}


@pytest.mark.parametrize("data", WRONG.values(), ids=WRONG.keys())
def test_wrong_plys_are_refused(data: bytes) -> None:
    with pytest.raises(SceneError, match="Gaussian") as raised:
        from_ply(data)
    assert raised.value.name == "file"
    assert "\n" not in raised.value.message


def test_counts_that_cannot_be_are_refused() -> None:
    with pytest.raises(LimitError):
        from_ply(ply(MAX_GAUSSIANS + 1))


@settings(deadline=None, max_examples=many(200))
@given(st.binary(max_size=200), st.integers(0, 400))
def test_any_bytes_give_gaussians_or_one_error(noise: bytes, at: int) -> None:
    data = ply()
    for text in (noise, data[:at] + noise + data[at + len(noise) :]):
        for read in (from_ply, from_splat):
            try:
                found = read(text)
            except SceneError as error:
                found = error
            if isinstance(found, SceneError):
                assert found.name in ("file", "size")
            else:
                assert torch.isfinite(found.covariances).all()


def test_files_that_are_not_there(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="cannot read"):
        read_gaussians(tmp_path / "none.ply")


@pytest.mark.parametrize(("backend", "ending"), [("splats-ply", ".ply"), ("splat", ".splat")])
def test_a_scene_is_exported(tmp_path: Path, backend: str, ending: str) -> None:
    scene = evaluate('(bind "a" (lambda () (transform (call "cube" :scale 2 :color [1 0 0]) (translate [0 5 0]))))')
    path = tmp_path / f"a{ending}"
    find(backend).run(scene, path, BackendOptions(settings={"gaussians": 600}))
    found = read_gaussians(path)
    assert len(found) == 600
    np.testing.assert_allclose(found.means.amin(0).numpy(), [-1.0, 4.0, -1.0], atol=1e-6)
    np.testing.assert_allclose(found.means.amax(0).numpy(), [1.0, 6.0, 1.0], atol=1e-6)
    np.testing.assert_allclose(found.colors.numpy(), np.tile([1.0, 0.0, 0.0], (600, 1)), atol=1e-6)
