"""Evaluation metrics: CLIP similarity, counting accuracy, LPIPS, and dynamic degree from optical flow by RAFT."""

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

from scenelang.backends.base import Progress, require, sub_progress
from scenelang.backends.files import reason_of
from scenelang.backends.neural.clip import SCORE_MODEL, ClipModel, ClipName, encode_images, load_clip
from scenelang.backends.neural.descriptions import spaced
from scenelang.backends.neural.diffusion import translate_out_of_memory
from scenelang.backends.neural.weights import INSTALL, ModelHub
from scenelang.backends.pictures.camera import PRESETS, Viewpoint
from scenelang.backends.pictures.film import Picture, PictureOptions, painters, picture_backend
from scenelang.backends.pictures.stage import MOST_FRAMES, Shot, film
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.scene.entity import Scene, count_words

# Rendered images: a turntable around the scene, or its frames by a fixed camera.


CLIP_VIEWS, LPIPS_VIEWS = 120, 20  # as in the paper
TURNTABLE = PRESETS["turntable"]
FIXED_VIEW = Viewpoint(TURNTABLE.azimuth, TURNTABLE.elevation)
_MAX_BYTES = 4_000_000_000  # of all images of a scene in memory


def turntable_shots(scene: Scene, count: int, width: int, height: int) -> list[Shot]:
    """Return ``count`` shots at equal angles of a full circle and equal distance; raises SceneError.

    The frames of a 4D scene are evenly distributed over the shots.
    """
    return film(scene, TURNTABLE, width, height, count, 360.0)


def fixed_shots(scene: Scene, width: int, height: int) -> list[Shot]:
    """Return a shot of every frame of a scene by a fixed camera; raises SceneError."""
    return film(scene, FIXED_VIEW, width, height, len(scene.frames), 0.0)


def render_shots(
    scene: Scene, shots: Sequence[Shot], options: PictureOptions, backend: str, progress: Progress | None = None
) -> list[Picture]:
    """Render ``shots`` as images (H, W, 3); raises SceneError if they cannot be rendered or exceed the memory limit."""
    check_memory(sum(shot.camera.width * shot.camera.height * 3 for shot in shots))
    (painter,) = painters(scene, options, [picture_backend(backend)], shots)
    count = len(shots)
    return [
        painter.paint(shot, sub_progress(progress, i / count, (i + 1) / count)).picture for i, shot in enumerate(shots)
    ]


def check_memory(size: int) -> None:
    """Raise SceneError("unsupported") if images of ``size`` bytes exceed the memory limit."""
    if size > _MAX_BYTES:
        message = f"the images of a scene would need more than {_MAX_BYTES:,} bytes"
        raise SceneError("unsupported", message, hint="choose a smaller --size")


# Films of other methods, evaluated like scenes.


ENDINGS = (".mp4", ".gif", ".webp", ".apng", ".png", ".jpg", ".jpeg")
_MAX_PIXELS = 64_000_000  # per image


def read_film(path: Path | str) -> list[Picture]:
    """Read all images (H, W, 3) of a video or image file, 8-bit sRGB.

    Raises SceneError: "file" if it is unreadable, "unsupported" if it exceeds the memory limit, "backend" if a package
    is missing.
    """
    source = Path(path)
    if source.suffix.lower() not in ENDINGS:
        raise SceneError("file", f"{path} is not a video: expected one of {' '.join(ENDINGS)}")
    frames = _video(source) if source.suffix.lower() == ".mp4" else _animation(source)
    images: list[Picture] = []
    size = 0
    for picture in frames:
        size += picture.nbytes
        check_memory(size)
        images.append(picture)
        if len(images) > MOST_FRAMES:
            raise SceneError("file", f"{path} has more than {MOST_FRAMES:,} frames")
    if not images:
        raise SceneError("file", f"{path} contains no images")
    return images


def _animation(path: Path) -> Iterator[Picture]:
    image = require("PIL.Image", "pillow")
    try:
        with image.open(path) as film:
            _check(path, film.width, film.height)
            for number in range(getattr(film, "n_frames", 1)):
                film.seek(number)
                yield np.asarray(film.convert("RGB"), np.uint8)
    except (OSError, ValueError, SyntaxError, image.DecompressionBombError) as error:
        raise _unreadable(path, error) from None


def _video(path: Path) -> Iterator[Picture]:
    av = require("av", "'scenelang[video]'")
    try:
        with av.open(str(path)) as container:
            for frame in container.decode(video=0):
                _check(path, frame.width, frame.height)
                picture: Any = frame.to_ndarray(format="rgb24")
                yield np.ascontiguousarray(picture)
    except (av.FFmpegError, OSError, ValueError, IndexError) as error:
        raise _unreadable(path, error) from None


def _check(path: Path, width: int, height: int) -> None:
    if width * height > _MAX_PIXELS:
        raise SceneError("file", f"{path} has more than {_MAX_PIXELS:,} pixels")


def _unreadable(path: Path, error: Exception) -> SceneError:
    return SceneError("file", f"cannot read {path} as a video: {reason_of(error)}")


# CLIP similarity of a scene's images to a text, the paper's metric of alignment.


class ClipScore:
    """CLIP similarity with the model ``name``, by default the paper's; raises SceneError("weights")."""

    def __init__(self, name: ClipName = SCORE_MODEL, hub: ModelHub | None = None, device: str = "cpu") -> None:
        self._model = load_clip(name, hub, device)

    @property
    def name(self) -> str:
        return str(self._model.name)

    def cosines(self, text: str, pictures: Sequence[Picture]) -> list[float]:
        """Return the cosine similarity of the text to each image (H, W, 3), from -1 to 1.

        Texts of more than 77 tokens are truncated, as CLIP does.
        """
        return cosines(self._model, text, pictures)


def cosines(model: ClipModel, text: str, pictures: Sequence[Picture]) -> list[float]:
    """Return the cosine similarities of ``ClipScore.cosines`` for a loaded model."""
    torch = require("torch", INSTALL)
    image = require("PIL.Image", "pillow")
    device = next(model.network.parameters()).device
    with torch.no_grad(), translate_out_of_memory():
        text_embedding: Any = model.network.encode_text(model.tokenizer([text]).to(device)).float()
        embeddings = encode_images(model, [image.fromarray(picture) for picture in pictures]).float()
    normalize = torch.nn.functional.normalize
    similarities = normalize(embeddings, dim=-1) @ normalize(text_embedding, dim=-1)[0]
    return [float(cosine) for cosine in similarities.tolist()]


# Counting accuracy: whether a scene has the numbers of entities that its task specifies.


def _split(words: str) -> list[str]:
    return words.split()


_UNITS = _split(
    "zero one two three four five six seven eight nine ten eleven twelve thirteen fourteen fifteen sixteen seventeen "
    "eighteen nineteen"
)
_TENS = _split("twenty thirty forty fifty sixty seventy eighty ninety")
_NUMBERS = {word: n for n, word in enumerate(_UNITS)} | {word: 10 * n for n, word in enumerate(_TENS, 2)}
_MULTIPLIERS = {"pair": 2, "couple": 2, "dozen": 12, "hundred": 100}
_STOP_WORDS = _split(
    "in on at by with of and or from to into onto over under around beside between that which who are is was were each "
    "per for as the a an"
)
_MEASURES = _split(
    "m cm mm km metre meter centimetre centimeter foot inch degree percent second minute hour year time way side row "
    "column layer level story storey floor d x"
)
_TOKEN = re.compile(r"\d+(?:\.\d+)?|[a-z]+(?:['’-][a-z]+)*|[^\sa-z\d]", re.I)
_MAX_PHRASE = 4  # words after a number that may name the entities
_MAX_TEXT = 10_000  # characters of a task that are parsed
_IRREGULAR = {"men": "man", "women": "woman", "people": "person", "children": "child", "mice": "mouse",
              "geese": "goose", "feet": "foot", "teeth": "tooth", "leaves": "leaf", "knives": "knife",
              "shelves": "shelf", "loaves": "loaf", "dice": "die", "movies": "movie", "cookies": "cookie",
              "buses": "bus", "shoes": "shoe", "toes": "toe", "pies": "pie"}  # fmt: skip


@dataclass(frozen=True, slots=True)
class CountQuery:
    """Expected ``count`` of entities; the phrase ``words``, in the singular, begins with their name."""

    count: int
    words: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class CountResult:
    """Number ``found`` of entities for a query; ``words`` are the program's matching words, empty without a match."""

    query: CountQuery
    words: tuple[str, ...]
    found: int

    @property
    def is_correct(self) -> bool:
        return self.found == self.query.count


def parse_counts(text: str) -> tuple[CountQuery, ...]:
    """Parse the counts in a text: "15 coke cans on a table" specifies 15 of "coke can".

    Sizes ("8 x 8", "two metres"), fractions and articles are ignored.
    """
    tokens = [token.lower() for token in _TOKEN.findall(text[:_MAX_TEXT])]
    queries: list[CountQuery] = []
    at = 0
    while at < len(tokens):
        count, after = _number(tokens, at)
        if count is None:
            at += 1
            continue
        words = _words(tokens, after)
        if words and words[0] not in _MEASURES and not _is_size(tokens, at, after):
            queries.append(CountQuery(count, words))
        at = after + len(words)
    return tuple(queries)


def count_queries(counts: Mapping[str, int]) -> tuple[CountQuery, ...]:
    """Convert a table of counts by word to queries."""
    return tuple(CountQuery(count, _normalize(word)) for word, count in counts.items())


def count_entities(scene: Scene, queries: Sequence[CountQuery]) -> tuple[CountResult, ...]:
    """Count the entities of each query in the first frame, by word."""
    counts = count_words(scene.frames[0])
    return tuple(_count(counts, query) for query in queries)


def is_accurate(results: Sequence[CountResult]) -> bool:
    """Return whether all counts are correct; the paper's counting accuracy is binary per scene."""
    return all(result.is_correct for result in results)


# --- texts -----------------------------------------------------------------------------------------------------------


def _number(tokens: Sequence[str], at: int) -> tuple[int | None, int]:
    """Parse the number at index ``at``, None if there is none; also returns the index after it."""
    token = tokens[at]
    if token in ("a", "an") and at + 1 < len(tokens) and tokens[at + 1] in _MULTIPLIERS:
        value, after = 1, at + 1
    elif token.isdecimal() and len(token) < 10:
        value, after = int(token), at + 1
    elif (parsed := _number_word(token)) is not None:
        value, after = parsed, at + 1
    else:
        return None, at + 1
    if after < len(tokens) and tokens[after] in _MULTIPLIERS:
        value, after = value * _MULTIPLIERS[tokens[after]], after + 1
        after += after < len(tokens) and tokens[after] == "of"
    return value, after


def _number_word(token: str) -> int | None:
    tens, _, unit = token.partition("-")
    if tens in _TENS and 0 < _NUMBERS.get(unit, 0) < 10:
        return _NUMBERS[tens] + _NUMBERS[unit]
    return _NUMBERS.get(token)


def _words(tokens: Sequence[str], after: int) -> tuple[str, ...]:
    words: list[str] = []
    for token in tokens[after : after + _MAX_PHRASE]:
        if token in _STOP_WORDS or not token[0].isalpha() or _number_word(token) is not None:
            break
        words.append(singular(token))
    return tuple(words)


def _is_size(tokens: Sequence[str], at: int, after: int) -> bool:
    """Return whether a number is a dimension: "8 x 8 chessboard", "5 by 5 grid"."""
    return (at > 0 and tokens[at - 1] in ("x", "by", "×")) or (after < len(tokens) and tokens[after] in ("x", "×"))


def singular(word: str) -> str:
    """Return the singular of an English noun, by rules and a table of exceptions."""
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


def _normalize(word: str) -> tuple[str, ...]:
    return tuple(singular(part) for part in spaced(word).lower().split())


def _count(counts: Mapping[str, int], query: CountQuery) -> CountResult:
    """Count the words equal to the longest possible part of the query, else those ending with it (soda cans: cans)."""
    names = {word: _normalize(word) for word in counts}
    for phrase in _subphrases(query.words):
        matches = [word for word, name in names.items() if name == phrase]
        if matches:
            return _sum(query, _prefer_singular(matches), counts)
    for phrase in _subphrases(query.words):
        matches = [word for word, name in names.items() if name[-1:] == phrase]
        if matches:
            return _sum(query, _prefer_singular(matches), counts)
    return CountResult(query, (), 0)


def _prefer_singular(words: Sequence[str]) -> list[str]:
    """Return only the singular words, if any: an entity `"cans"` usually consists of entities `"can"`."""
    return [word for word in words if " ".join(_normalize(word)) == spaced(word).lower()] or list(words)


def _sum(query: CountQuery, words: Sequence[str], counts: Mapping[str, int]) -> CountResult:
    return CountResult(query, tuple(words), sum(counts[word] for word in words))


def _subphrases(words: tuple[str, ...]) -> list[tuple[str, ...]]:
    """Return all contiguous parts of a phrase, the longest first, then by position."""
    return [words[i : i + size] for size in range(len(words), 0, -1) for i in range(len(words) - size + 1)]


# Dynamic degree: amount of motion in a film, from optical flow (VBench, Huang et al. 2024, section "Dynamic Degree").
# The constants are those of VBench's implementation.


SAMPLED_FPS = 8.0  # frame rate at which a film is sampled
_FASTEST_FRACTION = 0.05  # fraction of the pixels, by magnitude of flow, whose mean is the motion
_THRESHOLD, _REFERENCE_SIZE = 6.0, 256.0  # pixels of motion, for images of this size
_MIN_PAIRS, _REFERENCE_FRAMES = 4, 16  # pairs of frames above the threshold, for a film of this length


@dataclass(frozen=True, slots=True)
class DynamicDegree:
    """Motion of a film.

    Attributes
    ----------
    pixels
        Mean motion between sampled frames of the fastest 5 % of the pixels, in pixels.
    relative
        The same, in fractions of the shorter side of the image.
    is_dynamic
        VBench's classification of the film.
    """

    pixels: float
    relative: float
    is_dynamic: bool


def sample_frames(count: int, fps: float) -> list[int]:
    """Return the indices of the sampled frames of a film of ``count`` frames, about 8 per second."""
    return list(range(0, count, max(1, round(fps / SAMPLED_FPS))))


def motion(flow: npt.NDArray[np.floating]) -> float:
    """Return the mean magnitude of the largest 5 % of the vectors of a flow (H, W, 2), in pixels."""
    lengths = np.hypot(flow[..., 0], flow[..., 1]).ravel().astype(np.float64)
    count = max(1, int(lengths.size * _FASTEST_FRACTION))
    return float(np.partition(lengths, lengths.size - count)[lengths.size - count :].mean())


def dynamic_degree(motions: Sequence[float], fps: float, width: int, height: int) -> DynamicDegree:
    """Return the dynamic degree for the motions between consecutive sampled frames, of which there are ``fps``."""
    if not motions:
        return DynamicDegree(0.0, 0.0, False)
    size = min(width, height)
    threshold = max(1.0, SAMPLED_FPS / fps) * _THRESHOLD * size / _REFERENCE_SIZE
    required = max(1, round(_MIN_PAIRS * (len(motions) + 1) / _REFERENCE_FRAMES))
    pixels = float(np.mean(motions))
    return DynamicDegree(pixels, pixels / size, sum(each > threshold for each in motions) >= required)


def film_dynamic_degree(
    pictures: Sequence[Picture], fps: float, flow: Callable[[Picture, Picture], npt.NDArray[np.floating]]
) -> DynamicDegree:
    """Return the dynamic degree of a film of ``fps`` images (H, W, 3) per second; ``flow`` estimates optical flow."""
    sampled = [pictures[index] for index in sample_frames(len(pictures), fps)]
    step = max(1, round(fps / SAMPLED_FPS))
    height, width = pictures[0].shape[:2]
    return dynamic_degree([motion(flow(one, two)) for one, two in pairwise(sampled)], fps / step, width, height)


# Weights published by torchvision as single files.


_HOST = "https://download.pytorch.org/models/"


@dataclass(frozen=True, slots=True)
class PublishedWeights:
    """Name of a model on the hub, and torchvision's file, whose name ends in the checksum."""

    name: str
    file: str


ALEXNET = PublishedWeights("alexnet", "alexnet-owt-7be5be79.pth")
# ported from the original RAFT, trained on FlyingChairs and FlyingThings3D
RAFT_LARGE = PublishedWeights("raft_large", "raft_large_C_T_V1-22a6c225.pth")


def load_published(published: PublishedWeights, hub: ModelHub) -> dict[str, Any]:
    """Load the tensors of a published model from a local folder, torch's cache or the network.

    In a local folder this is torchvision's file, or else the only ``.pth`` or ``.safetensors`` file. Raises
    SceneError("weights") if they are unavailable.
    """

    def load_remote(_: str, offline: bool) -> dict[str, Any]:
        torch = require("torch", INSTALL)
        cached = Path(torch.hub.get_dir()) / "checkpoints" / published.file
        if cached.is_file():
            return _read(cached)
        if offline:
            raise FileNotFoundError(f"{published.file} is not in the cache, and downloads are disabled")
        tensors: dict[str, Any] = torch.hub.load_state_dict_from_url(
            f"{_HOST}{published.file}", map_location="cpu", check_hash=True, progress=False, weights_only=True
        )
        return tensors

    return hub.load(published.name, lambda folder: _read(_file_in(folder, published)), load_remote, _HOST)


def _file_in(folder: Path, published: PublishedWeights) -> Path:
    own = folder / published.file
    if own.is_file():
        return own
    files = sorted(path for path in folder.iterdir() if path.suffix in (".pth", ".safetensors"))
    if len(files) != 1:
        raise FileNotFoundError(f"{published.file} does not exist")
    return files[0]


def _read(path: Path) -> dict[str, Any]:
    if path.suffix == ".safetensors":
        tensors: dict[str, Any] = require("safetensors.torch", INSTALL).load_file(path)
        return tensors
    data = require("torch", INSTALL).load(path, map_location="cpu", weights_only=True)
    if not isinstance(data, dict):
        raise ValueError(f"{path.name} is not a state dict: expected tensors by name")
    return data


# LPIPS: perceptual distance in the features of AlexNet (Zhang et al. 2018), by the package `lpips`.


_MIN_ALEXNET_SIZE = 32  # pixels; the last layers of AlexNet would be empty for smaller images
_BATCH = 10


class Lpips:
    """LPIPS network; its linear layers are part of the package, AlexNet's weights come from the hub.

    Raises SceneError: "weights" if AlexNet's weights are unavailable or of another model, "backend" without the
    packages.
    """

    name = "alexnet"

    def __init__(self, hub: ModelHub | None = None, device: str = "cpu") -> None:
        self._torch = require("torch", INSTALL)
        package = require("lpips", INSTALL)
        with warnings.catch_warnings():  # it uses a deprecated argument of torchvision
            warnings.simplefilter("ignore")
            network = package.LPIPS(net="alex", pnet_rand=True, verbose=False)  # pnet_rand: do not download weights
        _load_backbone(network.net, load_published(ALEXNET, hub or ModelHub()))
        self._network = network.to(device).eval().requires_grad_(False)
        self._device = device

    def distances(self, reference: Picture, pictures: Sequence[Picture]) -> list[float]:
        """Return the distance of each of ``pictures`` (H, W, 3), of equal size, to ``reference``.

        ``reference`` is resized and cropped to their size. Raises SceneError("value") for images below 32 pixels.
        """
        height, width = pictures[0].shape[:2]
        if min(height, width) < _MIN_ALEXNET_SIZE:
            message = f"LPIPS requires images of at least {_MIN_ALEXNET_SIZE} pixels, not {width} x {height}"
            raise SceneError("value", message)
        target = self._tensor([resize_and_crop(reference, width, height)])
        values: list[float] = []
        with self._torch.no_grad(), translate_out_of_memory():
            for start in range(0, len(pictures), _BATCH):
                batch = self._tensor(pictures[start : start + _BATCH])
                values += self._network(target.expand(len(batch), -1, -1, -1), batch).flatten().tolist()
        return values

    def _tensor(self, pictures: Sequence[Picture]) -> Any:
        """Convert images to a tensor (N, 3, H, W) in [-1, 1]."""
        rows = self._torch.from_numpy(np.stack(list(pictures))).to(self._device)
        return rows.permute(0, 3, 1, 2).float() / 127.5 - 1.0


def resize_and_crop(picture: Picture, width: int, height: int) -> Picture:
    """Resize ``picture`` (H, W, 3), and crop it centrally to the aspect ratio of the new size."""
    image = require("PIL.Image", "pillow")
    if picture.shape[:2] == (height, width):
        return picture
    resized = require("PIL.ImageOps", "pillow").fit(image.fromarray(picture), (width, height), image.Resampling.BICUBIC)
    return np.asarray(resized, np.uint8)


def _load_backbone(backbone: Any, state: dict[str, Any]) -> None:
    """Load torchvision's weights into the slices of AlexNet: ``features.N.*`` becomes ``sliceK.N.*``."""
    renamed = {}
    for key, tensor in backbone.state_dict().items():
        part = key.partition(".")[2]
        weights = state.get(f"features.{part}", state.get(key))
        if getattr(weights, "shape", None) != tensor.shape:
            raise SceneError("weights", f"not AlexNet weights: unexpected shape of `features.{part}`")
        renamed[key] = weights
    backbone.load_state_dict(renamed)


# Optical flow by RAFT (Teed and Deng 2020), in torchvision's implementation.


Flow = npt.NDArray[np.float32]

ITERATIONS = 20  # as in VBench
_STRIDE, _MIN_FLOW_SIZE = 8, 128  # pixels: sides are multiples of the stride, the correlation pyramid has 4 levels


class Raft:
    """RAFT large of torchvision, or a ``network`` with the same interface.

    Raises SceneError: "weights" if the weights are unavailable or of another model, "backend" without the packages.
    """

    name = RAFT_LARGE.file

    def __init__(self, hub: ModelHub | None = None, device: str = "cpu", network: Any = None) -> None:
        self._torch = require("torch", INSTALL)
        self._network = (_load_raft(hub or ModelHub()) if network is None else network).to(device).eval()
        self._device = device

    def flow(self, before: Picture, after: Picture, iterations: int = ITERATIONS) -> Flow:
        """Estimate the flow (H, W, 2) from ``before`` to ``after`` (H, W, 3): motion right and down, in pixels."""
        height, width = before.shape[:2]
        top, bottom = _padding(height)
        left, right = _padding(width)
        with self._torch.no_grad(), translate_out_of_memory():
            pair = self._torch.from_numpy(np.stack([before, after])).to(self._device)
            rows = pair.permute(0, 3, 1, 2).float() / 127.5 - 1.0
            rows = self._torch.nn.functional.pad(rows, (left, right, top, bottom), mode="replicate")
            estimated = self._network(rows[:1], rows[1:], num_flow_updates=iterations)[-1][0]
        flow: Flow = estimated[:, top : top + height, left : left + width].permute(1, 2, 0).float().cpu().numpy()
        return flow


def _padding(size: int) -> tuple[int, int]:
    """Return the pixels to add before and after; as in the original RAFT, half on each side."""
    missing = max(_MIN_FLOW_SIZE, -(-size // _STRIDE) * _STRIDE) - size
    return missing // 2, missing - missing // 2


def _load_raft(hub: ModelHub) -> Any:
    flow = require("torchvision.models.optical_flow", INSTALL)
    network = flow.raft_large(weights=None)
    state = load_published(RAFT_LARGE, hub)
    try:
        network.load_state_dict(state)
    except (RuntimeError, AttributeError, TypeError) as error:
        raise SceneError("weights", "these are not the weights of torchvision's RAFT large") from error
    return network
