"""The pictures that metrics look at: a turn around the scene, or its frames by a camera that stands still."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import Progress, need, part_of
from scenelang.backends.files import reason_of
from scenelang.backends.neural.clip import JUDGE, ClipModel, ClipName, encode_images, load_clip
from scenelang.backends.neural.describing import spaced
from scenelang.backends.neural.diffusion import memory_told
from scenelang.backends.neural.weights import INSTALL, Shelf
from scenelang.backends.pictures.camera import PRESETS, Viewpoint
from scenelang.backends.pictures.film import Picture, PictureOptions, painters, picture_backend
from scenelang.backends.pictures.stage import MOST_FRAMES, Shot, film
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.scene.entity import Scene, count_words

CLIP_VIEWS, LPIPS_VIEWS = 120, 20  # as the paper's
AROUND = PRESETS["turntable"]
STEADY = Viewpoint(AROUND.azimuth, AROUND.elevation)
_MOST_BYTES = 4_000_000_000  # of all pictures of a scene in memory


def around(scene: Scene, count: int, width: int, height: int) -> list[Shot]:
    """``count`` shots from equal angles of a full circle, all as far away; a 4D scene goes on from one to the next, its
    frames evenly chosen. Raises SceneError."""
    return film(scene, AROUND, width, height, count, 360.0)


def steady(scene: Scene, width: int, height: int) -> list[Shot]:
    """Every frame of a scene once, from one place; raises SceneError."""
    return film(scene, STEADY, width, height, len(scene.frames), 0.0)


def drawn(
    scene: Scene, shots: Sequence[Shot], options: PictureOptions, backend: str, progress: Progress | None = None
) -> list[Picture]:
    """The pictures (H, W, 3) of ``shots``; raises SceneError where they cannot be drawn, or do not fit the memory."""
    check_room(sum(shot.camera.width * shot.camera.height * 3 for shot in shots))
    (painter,) = painters(scene, options, [picture_backend(backend)], shots)
    count = len(shots)
    return [painter.paint(shot, part_of(progress, i / count, (i + 1) / count)).picture for i, shot in enumerate(shots)]


def check_room(size: int) -> None:
    """Raises SceneError("unsupported") for pictures of ``size`` bytes where these are too many."""
    if size > _MOST_BYTES:
        raise SceneError("unsupported", "pictures of that size do not fit the memory", hint="choose a smaller --size")


# Films of others as pictures: what another method made, to be measured as scenes are.


ENDINGS = (".mp4", ".gif", ".webp", ".apng", ".png", ".jpg", ".jpeg")
_LARGEST = 64_000_000  # pixels of one picture


def read_film(path: Path | str) -> list[Picture]:
    """Every picture (H, W, 3) of a film or picture file, 8-bit sRGB.

    Raises SceneError: "file" where it is none that can be read, "unsupported" where it does not fit the memory,
    "backend" where a package is missing.
    """
    source = Path(path)
    if source.suffix.lower() not in ENDINGS:
        raise SceneError("file", f"{path} is not a video: expected one of {' '.join(ENDINGS)}")
    frames = _video(source) if source.suffix.lower() == ".mp4" else _animation(source)
    found: list[Picture] = []
    size = 0
    for picture in frames:
        size += picture.nbytes
        check_room(size)
        found.append(picture)
        if len(found) > MOST_FRAMES:
            raise SceneError("file", f"{path} has more than {MOST_FRAMES:,} frames")
    if not found:
        raise SceneError("file", f"{path} holds no pictures")
    return found


def _animation(path: Path) -> Iterator[Picture]:
    image = need("PIL.Image", "pillow")
    try:
        with image.open(path) as film:
            _check(path, film.width, film.height)
            for number in range(getattr(film, "n_frames", 1)):
                film.seek(number)
                yield np.asarray(film.convert("RGB"), np.uint8)
    except (OSError, ValueError, SyntaxError, image.DecompressionBombError) as error:
        raise _unread(path, error) from None


def _video(path: Path) -> Iterator[Picture]:
    av = need("av", "'scenelang[video]'")
    try:
        with av.open(str(path)) as container:
            for frame in container.decode(video=0):
                _check(path, frame.width, frame.height)
                picture: Any = frame.to_ndarray(format="rgb24")
                yield np.ascontiguousarray(picture)
    except (av.FFmpegError, OSError, ValueError, IndexError) as error:
        raise _unread(path, error) from None


def _check(path: Path, width: int, height: int) -> None:
    if width * height > _LARGEST:
        raise SceneError("file", f"{path} has more than {_LARGEST:,} pixels")


def _unread(path: Path, error: Exception) -> SceneError:
    return SceneError("file", f"cannot read {path} as a video: {reason_of(error)}")


# CLIP similarity: how much pictures of a scene are like a text (the paper's metric of alignment).


class ClipScore:
    """The judge, a CLIP model; by default that of the paper. Raises SceneError("weights") where it is not to be had."""

    def __init__(self, name: ClipName = JUDGE, shelf: Shelf | None = None, device: str = "cpu") -> None:
        self._model = load_clip(name, shelf, device)

    @property
    def name(self) -> str:
        return str(self._model.name)

    def cosines(self, text: str, pictures: Sequence[Picture]) -> list[float]:
        """The cosine of the text's embedding with that of each picture (H, W, 3), from -1 to 1. A text of more than
        the model's 77 tokens is cut, as CLIP does."""
        return cosines(self._model, text, pictures)


def cosines(model: ClipModel, text: str, pictures: Sequence[Picture]) -> list[float]:
    """As ``ClipScore.cosines``, by a model that is there."""
    torch = need("torch", INSTALL)
    image = need("PIL.Image", "pillow")
    device = next(model.network.parameters()).device
    with torch.no_grad(), memory_told():
        said: Any = model.network.encode_text(model.tokenizer([text]).to(device)).float()
        seen = encode_images(model, [image.fromarray(picture) for picture in pictures]).float()
    found = torch.nn.functional.normalize(seen, dim=-1) @ torch.nn.functional.normalize(said, dim=-1)[0]
    return [float(cosine) for cosine in found.tolist()]


# Counting accuracy: whether a scene has as many of a thing as the text of its task asks for.


def _listed(words: str) -> list[str]:
    return words.split()


_UNITS = _listed(
    "zero one two three four five six seven eight nine ten eleven twelve thirteen fourteen fifteen sixteen seventeen "
    "eighteen nineteen"
)
_TENS = _listed("twenty thirty forty fifty sixty seventy eighty ninety")
_NUMBERS = {word: n for n, word in enumerate(_UNITS)} | {word: 10 * n for n, word in enumerate(_TENS, 2)}
_TIMES = {"pair": 2, "couple": 2, "dozen": 12, "hundred": 100}
_ENDS = _listed(
    "in on at by with of and or from to into onto over under around beside between that which who are is was were each "
    "per for as the a an"
)
_MEASURES = _listed(
    "m cm mm km metre meter centimetre centimeter foot inch degree percent second minute hour year time way side row "
    "column layer level story storey floor d x"
)
_TOKEN = re.compile(r"\d+(?:\.\d+)?|[a-z]+(?:['’-][a-z]+)*|[^\sa-z\d]", re.I)
_LONGEST = 4  # words after a number that may name the things
_MOST_TEXT = 10_000  # characters of a task that are read
_IRREGULAR = {"men": "man", "women": "woman", "people": "person", "children": "child", "mice": "mouse",
              "geese": "goose", "feet": "foot", "teeth": "tooth", "leaves": "leaf", "knives": "knife",
              "shelves": "shelf", "loaves": "loaf", "dice": "die", "movies": "movie", "cookies": "cookie",
              "buses": "bus", "shoes": "shoe", "toes": "toe", "pies": "pie"}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Asked:
    """That there be ``count`` of what ``words``, one after the other and in the singular, name or begin to name."""

    count: int
    words: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Counted:
    """What was asked for and what there is: ``words`` are the program's, none where it has none of the name."""

    asked: Asked
    words: tuple[str, ...]
    found: int

    @property
    def is_right(self) -> bool:
        return self.found == self.asked.count


def asked_in(text: str) -> tuple[Asked, ...]:
    """The numbers of things that a text asks for: "15 coke cans on a table" asks for 15. Sizes ("8 x 8", "two
    metres"), fractions and articles ask for nothing."""
    tokens = [token.lower() for token in _TOKEN.findall(text[:_MOST_TEXT])]
    found: list[Asked] = []
    at = 0
    while at < len(tokens):
        count, after = _number(tokens, at)
        if count is None:
            at += 1
            continue
        words = _words(tokens, after)
        if words and words[0] not in _MEASURES and not _is_size(tokens, at, after):
            found.append(Asked(count, words))
        at = after + len(words)
    return tuple(found)


def asked_of(counts: Mapping[str, int]) -> tuple[Asked, ...]:
    """What a table of numbers by word asks for."""
    return tuple(Asked(count, _normal(word)) for word, count in counts.items())


def counted(scene: Scene, asked: Sequence[Asked]) -> tuple[Counted, ...]:
    """How many of each there are in the first frame, by the words of its entities."""
    counts = count_words(scene.frames[0])
    return tuple(_counted(counts, one) for one in asked)


def is_accurate(found: Sequence[Counted]) -> bool:
    """The paper's: a scene is right or it is not."""
    return all(one.is_right for one in found)


# --- texts -----------------------------------------------------------------------------------------------------------


def _number(tokens: Sequence[str], at: int) -> tuple[int | None, int]:
    """The number that begins at a token, None where none does, and the place after it."""
    token = tokens[at]
    if token in ("a", "an") and at + 1 < len(tokens) and tokens[at + 1] in _TIMES:
        value, after = 1, at + 1
    elif token.isdecimal() and len(token) < 10:
        value, after = int(token), at + 1
    elif (read := _worded(token)) is not None:
        value, after = read, at + 1
    else:
        return None, at + 1
    if after < len(tokens) and tokens[after] in _TIMES:
        value, after = value * _TIMES[tokens[after]], after + 1
        after += after < len(tokens) and tokens[after] == "of"
    return value, after


def _worded(token: str) -> int | None:
    tens, _, unit = token.partition("-")
    if tens in _TENS and 0 < _NUMBERS.get(unit, 0) < 10:
        return _NUMBERS[tens] + _NUMBERS[unit]
    return _NUMBERS.get(token)


def _words(tokens: Sequence[str], after: int) -> tuple[str, ...]:
    words: list[str] = []
    for token in tokens[after : after + _LONGEST]:
        if token in _ENDS or not token[0].isalpha() or _worded(token) is not None:
            break
        words.append(singular(token))
    return tuple(words)


def _is_size(tokens: Sequence[str], at: int, after: int) -> bool:
    """Whether a number is a side of something: "8 x 8 chessboard", "5 by 5 grid"."""
    return (at > 0 and tokens[at - 1] in ("x", "by", "×")) or (after < len(tokens) and tokens[after] in ("x", "×"))


def singular(word: str) -> str:
    """An English noun without its plural's ending, as far as rules tell."""
    if word in _IRREGULAR:
        return _IRREGULAR[word]
    if word.endswith("ies") and len(word) > 4:
        return word[:-3] + "y"
    if re.search(r"(ch|sh|ss|x|z|o)es\Z", word):
        return word[:-2]
    if word.endswith("s") and not word.endswith(("ss", "us", "is")) and len(word) > 2:
        return word[:-1]
    return word


# --- scenes ----------------------------------------------------------------------------------------------------------


def _normal(word: str) -> tuple[str, ...]:
    return tuple(singular(part) for part in spaced(word).lower().split())


def _counted(counts: Mapping[str, int], asked: Asked) -> Counted:
    """The longest of the words asked for that name something. Else whatever ends as these do: soda cans are cans."""
    names = {word: _normal(word) for word in counts}
    for wanted in _parts(asked.words):
        found = [word for word, name in names.items() if name == wanted]
        if found:
            return _sum(asked, _singulars(found), counts)
    for wanted in _parts(asked.words):
        found = [word for word, name in names.items() if name[-1:] == wanted]
        if found:
            return _sum(asked, _singulars(found), counts)
    return Counted(asked, (), 0)


def _singulars(words: Sequence[str]) -> list[str]:
    """Of names and their plurals the names, since `"cans"` makes many of `"can"`."""
    return [word for word in words if " ".join(_normal(word)) == spaced(word).lower()] or list(words)


def _sum(asked: Asked, words: Sequence[str], counts: Mapping[str, int]) -> Counted:
    return Counted(asked, tuple(words), sum(counts[word] for word in words))


def _parts(words: tuple[str, ...]) -> list[tuple[str, ...]]:
    """All pieces of a phrase, the longest first, of equals the first."""
    return [words[i : i + size] for size in range(len(words), 0, -1) for i in range(len(words) - size + 1)]


# Dynamic degree: how much moves in a film, from optical flow (VBench, Huang et al. 2024).


SAMPLED_FPS = 8.0  # pictures per second that are looked at
_FASTEST = 0.05  # the share of pixels that counts, the fastest
_THRESHOLD, _AT = 6.0, 256.0  # pixels, in pictures of that size
_PAIRS, _OF = 4, 16  # so many pairs must move, of so many pictures


@dataclass(frozen=True, slots=True)
class DynamicDegree:
    """``pixels``: how far the fastest twentieth of the pixels goes from one picture to the next, on average;
    ``share``: the same over the shorter side of the picture; ``is_dynamic``: what VBench says of the film."""

    pixels: float
    share: float
    is_dynamic: bool


def sampled(count: int, fps: float) -> list[int]:
    """The numbers of the pictures of a film of ``count`` that are looked at: about 8 per second."""
    return list(range(0, count, max(1, round(fps / SAMPLED_FPS))))


def motion(flow: npt.NDArray[np.floating]) -> float:
    """The mean length of the fastest twentieth of a flow (H, W, 2), in pixels."""
    lengths = np.hypot(flow[..., 0], flow[..., 1]).ravel().astype(np.float64)
    count = max(1, int(lengths.size * _FASTEST))
    return float(np.partition(lengths, lengths.size - count)[lengths.size - count :].mean())


def degree(motions: Sequence[float], fps: float, width: int, height: int) -> DynamicDegree:
    """From the motion of each pair of neighbours among the pictures that are looked at, ``fps`` of them per second."""
    if not motions:
        return DynamicDegree(0.0, 0.0, False)
    size = min(width, height)
    threshold = max(1.0, SAMPLED_FPS / fps) * _THRESHOLD * size / _AT
    wanted = max(1, round(_PAIRS * (len(motions) + 1) / _OF))
    pixels = float(np.mean(motions))
    return DynamicDegree(pixels, pixels / size, sum(one > threshold for one in motions) >= wanted)


def degree_of_film(
    pictures: Sequence[Picture], fps: float, flow: Callable[[Picture, Picture], npt.NDArray[np.floating]]
) -> DynamicDegree:
    """The degree of a film of ``fps`` pictures (H, W, 3) per second, by a function that gives the flow of two."""
    chosen = [pictures[number] for number in sampled(len(pictures), fps)]
    step = max(1, round(fps / SAMPLED_FPS))
    height, width = pictures[0].shape[:2]
    return degree([motion(flow(one, two)) for one, two in pairwise(chosen)], fps / step, width, height)


# Weights that torchvision publishes as single files, by name.


_HOST = "https://download.pytorch.org/models/"


@dataclass(frozen=True, slots=True)
class Published:
    """A model's name on the shelf, and its file as torchvision calls it, whose last part is the sum that is checked."""

    name: str
    file: str


ALEXNET = Published("alexnet", "alexnet-owt-7be5be79.pth")
RAFT_LARGE = Published("raft_large", "raft_large_C_T_V1-22a6c225.pth")  # ported from RAFT's own: chairs, then things


def state_of(published: Published, shelf: Shelf) -> dict[str, Any]:
    """The tensors of a published model: from the folder on the shelf that is called after it (its file there, else the
    only ``.pth`` or ``.safetensors``), from torch's own cache, or from the network.

    Raises SceneError("weights") where they are not to be had.
    """

    def hub(_: str, offline: bool) -> dict[str, Any]:
        torch = need("torch", INSTALL)
        kept = Path(torch.hub.get_dir()) / "checkpoints" / published.file
        if kept.is_file():
            return _read(kept)
        if offline:
            raise FileNotFoundError(f"{published.file} has not been fetched")
        found: dict[str, Any] = torch.hub.load_state_dict_from_url(
            f"{_HOST}{published.file}", map_location="cpu", check_hash=True, progress=False, weights_only=True
        )
        return found

    return shelf.load(published.name, lambda folder: _read(_file_in(folder, published)), hub, _HOST)


def _file_in(folder: Path, published: Published) -> Path:
    own = folder / published.file
    if own.is_file():
        return own
    found = sorted(path for path in folder.iterdir() if path.suffix in (".pth", ".safetensors"))
    if len(found) != 1:
        raise FileNotFoundError(f"there is no {published.file}")
    return found[0]


def _read(path: Path) -> dict[str, Any]:
    if path.suffix == ".safetensors":
        tensors: dict[str, Any] = need("safetensors.torch", INSTALL).load_file(path)
        return tensors
    found = need("torch", INSTALL).load(path, map_location="cpu", weights_only=True)
    if not isinstance(found, dict):
        raise ValueError(f"{path.name} holds no named tensors")
    return found


# LPIPS: how unlike pictures are to the features of AlexNet (Zhang et al. 2018), by the package `lpips`.


_LEAST_ALEXNET_SIZE = 32  # pixels: below, AlexNet has nothing left in its last layers
_BATCH = 10


class Lpips:
    """The network: its linear heads come with the package, AlexNet's weights from the shelf.

    Raises SceneError: "weights" where AlexNet's weights are not to be had or are another model's, "backend" without
    the packages.
    """

    name = "alexnet"

    def __init__(self, shelf: Shelf | None = None, device: str = "cpu") -> None:
        self._torch = need("torch", INSTALL)
        package = need("lpips", INSTALL)
        with warnings.catch_warnings():  # it calls torchvision in an old way
            warnings.simplefilter("ignore")
            network = package.LPIPS(net="alex", pnet_rand=True, verbose=False)  # pnet_rand: without a download
        _fill(network.net, state_of(ALEXNET, shelf or Shelf()))
        self._network = network.to(device).eval().requires_grad_(False)
        self._device = device

    def distances(self, wanted: Picture, pictures: Sequence[Picture]) -> list[float]:
        """How far each of ``pictures`` (H, W, 3), which have one size, is from ``wanted``, which is brought to that
        size, cut where its shape is another. Raises SceneError("value") for pictures below 32 pixels."""
        height, width = pictures[0].shape[:2]
        if min(height, width) < _LEAST_ALEXNET_SIZE:
            raise SceneError(
                "value", f"LPIPS needs pictures of {_LEAST_ALEXNET_SIZE} pixels or more, not {width} x {height}"
            )
        target = self._tensor([fitted(wanted, width, height)])
        found: list[float] = []
        with self._torch.no_grad(), memory_told():
            for start in range(0, len(pictures), _BATCH):
                batch = self._tensor(pictures[start : start + _BATCH])
                found += self._network(target.expand(len(batch), -1, -1, -1), batch).flatten().tolist()
        return found

    def _tensor(self, pictures: Sequence[Picture]) -> Any:
        """(N, 3, H, W) from -1 to 1."""
        rows = self._torch.from_numpy(np.stack(list(pictures))).to(self._device)
        return rows.permute(0, 3, 1, 2).float() / 127.5 - 1.0


def fitted(picture: Picture, width: int, height: int) -> Picture:
    """``picture`` at another size, cut to its middle where its shape is another."""
    image = need("PIL.Image", "pillow")
    if picture.shape[:2] == (height, width):
        return picture
    made = need("PIL.ImageOps", "pillow").fit(image.fromarray(picture), (width, height), image.Resampling.BICUBIC)
    return np.asarray(made, np.uint8)


def _fill(backbone: Any, state: dict[str, Any]) -> None:
    """Give the slices of AlexNet's features their weights: ``features.N.*`` is ``sliceK.N.*``."""
    wanted = backbone.state_dict()
    filled = {}
    for key, tensor in wanted.items():
        part = key.partition(".")[2]
        found = state.get(f"features.{part}", state.get(key))
        if getattr(found, "shape", None) != tensor.shape:
            raise SceneError("weights", f"not AlexNet weights: unexpected shape of `features.{part}`")
        filled[key] = found
    backbone.load_state_dict(filled)


# Optical flow by RAFT (Teed and Deng 2020), as torchvision has it: where the pixels of a picture go in the next.


Flow = npt.NDArray[np.float32]

ITERATIONS = 20  # as VBench's
_UNIT, _LEAST_FLOW_SIZE = 8, 128  # pixels: sides are whole multiples, the pyramid of correlations needs so many


class Raft:
    """RAFT, large, of torchvision's architecture; ``network`` may be one of the same interface that is there.

    Raises SceneError: "weights" where the weights are not to be had or are another model's, "backend" without the
    packages.
    """

    name = RAFT_LARGE.file

    def __init__(self, shelf: Shelf | None = None, device: str = "cpu", network: Any = None) -> None:
        self._torch = need("torch", INSTALL)
        self._network = (_loaded(shelf or Shelf()) if network is None else network).to(device).eval()
        self._device = device

    def flow(self, before: Picture, after: Picture, iterations: int = ITERATIONS) -> Flow:
        """How far each pixel of ``before`` (H, W, 3) moves to ``after``: (H, W, 2), right and down, in pixels."""
        height, width = before.shape[:2]
        top, bottom = _margins(height)
        left, right = _margins(width)
        with self._torch.no_grad(), memory_told():
            pair = self._torch.from_numpy(np.stack([before, after])).to(self._device)
            rows = pair.permute(0, 3, 1, 2).float() / 127.5 - 1.0
            rows = self._torch.nn.functional.pad(rows, (left, right, top, bottom), mode="replicate")
            found = self._network(rows[:1], rows[1:], num_flow_updates=iterations)[-1][0]
        flow: Flow = found[:, top : top + height, left : left + width].permute(1, 2, 0).float().cpu().numpy()
        return flow


def _margins(size: int) -> tuple[int, int]:
    """Pixels before and after, as RAFT's own code pads: the edge repeated, half on each side."""
    missing = max(_LEAST_FLOW_SIZE, -(-size // _UNIT) * _UNIT) - size
    return missing // 2, missing - missing // 2


def _loaded(shelf: Shelf) -> Any:
    flow = need("torchvision.models.optical_flow", INSTALL)
    network = flow.raft_large(weights=None)
    state = state_of(RAFT_LARGE, shelf)
    try:
        network.load_state_dict(state)
    except (RuntimeError, AttributeError, TypeError) as error:
        raise SceneError("weights", "not the weights of torchvision's RAFT large") from error
    return network
