"""Pictures: drafts beside PyVista's and Mitsuba's, scenes in Mitsuba, splats; ``pictures.py TASK`` runs one."""

from __future__ import annotations

import json
import re
import sys
import tempfile
from collections.abc import Callable, Iterator
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from measuring import ROOT, Absent, Child, Goal, Pair, Row, clocked, command, peak_memory, peer, peer_process, timed
from programs import PRIMITIVES, SPONGE

COUNT, SIDE = 200, 512
EXAMPLE = ROOT / "examples" / "chessboard.scene"


def drafts(*words: str) -> Iterator[Pair]:
    """A draft of 200 primitives as a command, beside a picture by a peer as a command."""
    with tempfile.TemporaryDirectory() as folder:
        program = Path(folder) / "primitives.scene"
        program.write_text(PRIMITIVES.format(count=COUNT), "utf-8")
        ours = command("render", str(program), "-o", f"{folder}/out.png", "--size", f"{SIDE}x{SIDE}", "-q")
        yield Pair(ours, peer_process(*words))


def draft_beside_final() -> list[Pair]:
    """The default picture of an example, beside a path traced one."""
    import scenelang as sl

    scene = sl.load(EXAMPLE)
    draft = timed(lambda: scene.render())
    return [Pair(draft, timed(lambda: scene.render(quality="final", settings={"samples": 16})))]


def fifth() -> float:
    """Seconds of the fifth of five drafts."""
    import scenelang as sl

    scene = sl.evaluate(PRIMITIVES.format(count=COUNT))
    return [clocked(lambda: scene.render(size=(SIDE, SIDE))) for _ in range(5)][-1]


FINALS = ("chessboard", "toys", "still-life")  # exact shapes, solids, textures with lights of the program
SAMPLES, WIDTH, HEIGHT = 64, 200, 150


def final(name: str, denoise: str) -> float:
    """Seconds of a final image of an example, from the evaluated scene to the pixels."""
    import scenelang as sl

    scene = sl.load(ROOT / "examples" / f"{name}.scene")

    def render(width: int, height: int) -> Any:
        settings = {"samples": SAMPLES, "variant": "scalar", "denoise": denoise}
        return scene.render(quality="final", size=(width, height), settings=settings)

    render(8, 6)  # imports
    return clocked(lambda: render(WIDTH, HEIGHT))


def finals() -> Iterator[Pair]:
    """Final images without the denoiser, beside the same exported scenes in Mitsuba alone."""
    with tempfile.TemporaryDirectory() as folder:
        for name in FINALS:
            path = Path(folder) / f"{name}.xml"
            command("export", str(ROOT / "examples" / f"{name}.scene"), "-o", str(path), "-q")()
            text = path.read_text("utf-8")
            for side, pixels in (("width", WIDTH), ("height", HEIGHT)):
                text = re.sub(rf'(name="{side}" value=)"\d+"', rf'\1"{pixels}"', text)
            path.write_text(text, "utf-8")
            yield Pair(of("final", name, "off"), peer("mitsuba_file", str(path), str(SAMPLES)))


def film() -> float:
    """Seconds of a draft film of 144 frames."""
    import scenelang as sl

    scene = sl.load(ROOT / "examples" / "orrery.scene")
    with tempfile.TemporaryDirectory() as folder:
        return clocked(lambda: scene.film(frames=144, size=(320, 240)).save(f"{folder}/film.gif"))


def loaded(way: str, level: str) -> float:
    """Seconds to load a sponge into Mitsuba: ``placed`` as `render --quality final` does, ``plain`` a shape a cube."""
    import numpy as np

    import scenelang as sl
    from scenelang.backends.pictures.camera import Viewpoint
    from scenelang.backends.pictures.film import PictureOptions
    from scenelang.backends.pictures.mitsuba import MitsubaPainter
    from scenelang.backends.pictures.mitsuba_scene import surroundings
    from scenelang.backends.pictures.stage import staging_of, still

    scene = sl.evaluate(SPONGE.format(level=level)).graph
    options = PictureOptions(width=128, height=128, settings={"samples": 1})
    shot = still(scene, Viewpoint(), 0, 128, 128)

    def load() -> Any:
        staging = staging_of(scene, [0], 5_000_000)
        painter = MitsubaPainter(staging, options, 1)
        mi, stage = painter.mitsuba, staging.stage(shot)
        shapes = painter.shapes_of(0, stage) if way == "placed" else plain(mi, stage.solids.matrices)
        return mi, mi.load_dict(surroundings(mi, stage, 8) | shapes)

    kept: list[Any] = []
    seconds = clocked(lambda: kept.extend(load()))
    np.array(kept[0].render(kept[1], spp=4))  # for the memory
    return seconds


def plain(mi: Any, matrices: Any) -> dict[str, Any]:
    """One cube for every primitive."""
    import numpy as np

    bsdf = mi.load_dict({"type": "diffuse"})
    poses = [np.concatenate([matrix, [[0.0, 0.0, 0.0, 1.0]]]) for matrix in matrices]
    return {f"s{i}": {"type": "cube", "bsdf": bsdf, "to_world": mi.ScalarTransform4f(p)} for i, p in enumerate(poses)}


def splats(count: int, size: int) -> list[Pair]:
    """Posed Gaussians forward and backward, compiled and in torch, on one thread each."""
    if find_spec("torch") is None or find_spec("numba") is None:
        raise Absent("torch or numba is not installed (`scenelang[neural]`)")
    import numpy as np
    import torch

    from scenelang.backends.neural.splats import rasterise_numba, rasterise_torch
    from scenelang.backends.neural.splats.gaussians import Gaussians, apply_pose, view_of
    from scenelang.backends.neural.splats.rasterise import rasterise_by
    from scenelang.backends.pictures.camera import Viewpoint, place

    torch.set_num_threads(1)
    chance = torch.Generator().manual_seed(0)
    gaussians = Gaussians(
        torch.rand(count, 3, generator=chance) * 2.0 - 1.0,
        torch.randn(count, 3, generator=chance) * 0.3 - 4.0,
        torch.randn(count, 4, generator=chance),
        torch.randn(count, generator=chance),
        torch.rand(count, 3, generator=chance),
    )
    columns = (gaussians.means, gaussians.log_scales, gaussians.quaternions, gaussians.opacity_logits, gaussians.colors)
    view = view_of(place(Viewpoint(), -np.ones(3), np.ones(3), size, size), gaussians.means)

    def step(engine: Any) -> None:
        for column in columns:
            column.grad = None
            column.requires_grad_()
        drawn = rasterise_by(engine, apply_pose(gaussians, torch.eye(3), torch.zeros(3)), view)
        (drawn.color.square().sum() + drawn.alpha.sum() + drawn.depth.sum()).backward()

    step(rasterise_numba)  # compiles
    return [Pair(timed(partial(step, rasterise_numba)), timed(partial(step, rasterise_torch)))]


TASKS: dict[str, Callable[..., float]] = {"fifth": fifth, "loaded": loaded, "final": final, "film": film}


def of(*words: str, memory: str = "") -> Child:
    """Return the probe of a task in a process of its own."""
    return Child("pictures.py", words, memory)


def main(task: str, *words: str) -> None:
    seconds = TASKS[task](*words)
    print(json.dumps({"seconds": seconds, "memory": peak_memory()}))


_PICTURE = (str(SIDE), str(COUNT))
ROWS = (
    Row(
        "draft of 200 primitives, 512 x 512, a command", partial(drafts, "pyvista", *_PICTURE), "PyVista, no shadows",
        (Goal(1.6, "ours"),), rounds=3,
    ),
    Row(
        "draft of 200 primitives, the fifth in a process",
        lambda: [Pair(of("fifth"), peer("fifth", "pyvista", *_PICTURE))], "PyVista, no shadows", (Goal(1.0, "ours"),),
        rounds=1,
    ),
    Row(
        "draft of 200 primitives beside Mitsuba alone", partial(drafts, "mitsuba", *_PICTURE, "16"),
        "Mitsuba, 16 samples", rounds=1,
    ),
    Row(
        "draft of 200 primitives beside pyrender", partial(drafts, "pyrender", *_PICTURE), "pyrender, no shadows",
        rounds=1,
    ),
    Row(
        "final images without the denoiser", finals, "Mitsuba alone on the exported scenes", (Goal(1.1),), rounds=1,
        summary=max,
    ),
    Row(
        "final images with the denoiser",
        lambda: [Pair(of("final", name, "on"), of("final", name, "off")) for name in FINALS], "without it", rounds=1,
    ),
    Row("draft film of 144 frames, 320 x 240", lambda: [Pair(of("film"))], goals=(Goal(144 * 0.15, "ours"),), rounds=1),
    Row("draft of the chess set, 512 x 512", draft_beside_final, "final, 16 samples", (Goal(1.0),), rounds=1),
    Row(
        "load 8,000 cubes into Mitsuba", lambda: [Pair(of("loaded", "placed", "3"), of("loaded", "plain", "3"))],
        "one shape per cube", (Goal(1.0),), rounds=1,
    ),
    Row(
        "load 160,000 cubes into Mitsuba", lambda: [Pair(of("loaded", "placed", "4", memory="memory"))],
        goals=(Goal(5.0, "ours"), Goal(1.5e9, "memory")), rounds=2,
    ),
    Row("10,000 Gaussians and derivatives", partial(splats, 10_000, 128), "torch", (Goal(0.3, "ours"),), rounds=3),
)  # fmt: skip


if __name__ == "__main__":
    main(*sys.argv[1:])
