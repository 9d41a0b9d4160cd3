"""Description of datasets: statistics, the dataset card, and the contact sheet that previews a spec."""

from __future__ import annotations

import json
import math
import platform
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import require
from scenelang.backends.labels.dataset import depth_picture, flow_picture, instance_color, with_tracks
from scenelang.backends.labels.ground_truth import HIDDEN, VISIBLE, Flow, Tracks
from scenelang.backends.labels.object_labels import OTHER
from scenelang.backends.pictures.camera import Viewpoint
from scenelang.backends.pictures.film import save_picture
from scenelang.backends.surfaces.appearance import word_color
from scenelang.datasets.making import Maker, SampleFailure, decoded
from scenelang.datasets.owned import CARD, CARD_TITLE
from scenelang.datasets.sampler import draw_sample, views_of
from scenelang.datasets.spec import Spec, read_spec
from scenelang.datasets.store import Plan, Store
from scenelang.grammar.diagnostics import Diagnostic, SceneError, UsageError
from scenelang.grammar.settings import typed

Picture = npt.NDArray[np.uint8]
Color = tuple[int, int, int]
Entry = tuple[str, Color | None]  # a text, and the color that it explains
MAX_PREVIEW = 400  # samples of a contact sheet
_MAX_DRAWN = 2_000  # draws whose distribution a preview shows
_BARS = 16  # of a histogram
_MAX_BARS = 12  # rows of a table of values
_TILE_PX = 160  # longest side of a tile
_GAP, _LINE, _MARGIN = 6, 15, 12  # pixels
_INK, _PAPER, _BAR = (24, 26, 32), (255, 255, 255), (164, 190, 232)
_SILENT = ("seed",)  # quantities without a histogram
_MAX_LINES = 3  # of a list of words
# pixels of a side by the ending of the image format, as the formats allow
_MAX_SHEET_PX = {".png": 1 << 30, ".jpg": 65_500, ".jpeg": 65_500, ".webp": 16_383}
_OTHER = "other"  # label of words without a class
_STATES: Mapping[int, Color] = {HIDDEN: (240, 140, 40), VISIBLE: (90, 170, 90)}
_TITLES = {"flow_state.png": "flow_state, orange: hidden", "tracks.npz": "tracks of all frames"}
_APPROXIMATE = "approximate"  # the split of a scene is decided once it is evaluated


# --- statistics ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Quantity:
    """Distribution of one quantity: ``numbers`` if all values are numbers, else ``counts`` by value.

    ``note`` restricts the distribution, such as "approximate".
    """

    name: str
    numbers: npt.NDArray[np.float64] | None
    counts: Mapping[str, int]
    note: str = ""

    def summary(self) -> str:
        """Return the distribution in a line."""
        if self.numbers is not None:
            low, mean, high = (float(f(self.numbers)) for f in (np.min, np.mean, np.max))
            return f"{low:.4g} to {high:.4g}, mean {mean:.4g}"
        shown = [f"{value}: {count:,}" for value, count in list(self.counts.items())[:_MAX_BARS]]
        more = len(self.counts) - len(shown)
        return ", ".join(shown) + (f", and {more:,} more" if more else "")

    def bars(self) -> list[tuple[str, int]]:
        """Return the labels and the counts of the bars of a histogram."""
        is_whole = self.numbers is not None and bool((self.numbers == np.rint(self.numbers)).all())
        if self.numbers is None or (is_whole and len(self.counts) <= _MAX_BARS):
            return list(self.counts.items())[:_MAX_BARS]
        counts, edges = np.histogram(self.numbers, _BARS)
        return [(f"{edge:.3g}", int(count)) for edge, count in zip(edges, counts, strict=False)]


def quantities_of(values: Sequence[Mapping[str, Any]]) -> list[Quantity]:
    """Return the distributions of the quantities that vary among the ``values`` of samples."""
    quantities = []
    for name in sorted({name for sample in values for name in sample}):
        column = [sample[name] for sample in values if name in sample]
        counts = Counter(map(_shown, column))
        if len(counts) > 1 and name not in _SILENT:
            quantities.append(_quantity(name, column, counts))
    return quantities


def _quantity(name: str, column: Sequence[Any], counts: Counter[str]) -> Quantity:
    """Return the distribution of one quantity from its column of values."""
    is_number = all(isinstance(value, int | float) and not isinstance(value, bool) for value in column)
    if is_number:
        ordered = sorted(counts.items(), key=lambda pair: float(pair[0]))
        return Quantity(name, np.array(column, np.float64), dict(ordered))
    return Quantity(name, None, dict(counts.most_common()))


def _shown(value: Any) -> str:
    """Return a value as text."""
    if isinstance(value, tuple | list):
        return f"[{', '.join(map(_shown, value))}]"
    return f"{value:.6g}" if isinstance(value, float) else str(value).lower() if isinstance(value, bool) else str(value)


# --- the card --------------------------------------------------------------------------------------------------------


def write_card(store: Store, plan: Plan, records: Sequence[Mapping[str, Any]], digest: str) -> None:
    """Write the dataset card: contents, origin and use of the dataset."""
    store.write(CARD, card_of(plan, records, digest).encode("utf-8"))


def card_of(plan: Plan, records: Sequence[Mapping[str, Any]], digest: str) -> str:
    """Return the text of a dataset card; its head is the metadata that Hugging Face reads."""
    splits: Counter[str] = Counter()
    for record in records:
        splits.update({file["split"]: file["items"] for file in record["files"]})
    size = sum(file["bytes"] for record in records for file in record["files"])
    ending = "parquet" if plan.format == "parquet" else "tar"
    head = ["---", f"license: {_yaml(plan.licence or 'unknown')}", "tags: [synthetic, scenelang]", "configs:"]
    head += ["- config_name: default", "  data_files:"]
    for split in sorted(splits):
        head += [f"  - split: {_yaml(split)}", f"    path: {_yaml(f'{split}-*.{ending}')}"]
    parts = [*head, "---", "", CARD_TITLE, ""]
    parts += _rows(("split", "pictures"), sorted((name, f"{count:,}") for name, count in splits.items()))
    failures = Counter(failure["code"] for record in records for failure in record["failures"])
    samples = sum(record["samples"] for record in records)
    facts = [("samples", f"{samples:,} of {plan.count:,}"), ("bytes", f"{size:,}"), ("digest", f"`{digest}`")]
    facts += [("spec", f"`{plan.spec_digest}`"), ("versions", versions())]
    facts += [("failures", ", ".join(f"{code}: {n:,}" for code, n in sorted(failures.items())) or "none")]
    parts += ["", *_rows(("", ""), facts), "", "## Classes", ""]
    shown: Counter[str] = Counter()
    for record in records:
        shown.update(record["shown"])
    parts += _rows(("class", "word", "visible things"), [(str(n), w, f"{shown[w]:,}") for w, n in plan.classes.items()])
    values = [sample for record in records for sample in record["values"]]
    parts += [
        "",
        "## What varies",
        "",
        *_rows(("quantity", "values"), [(q.name, q.summary()) for q in quantities_of(values)]),
    ]
    files = [f"`{name}`" for name in plan.columns]
    parts += [
        "",
        "## Files of a picture",
        "",
        ", ".join(files),
        "",
        "## Spec",
        "",
        "```toml",
        plan.text.rstrip(),
        "```",
        "",
    ]
    return "\n".join(parts)


def _yaml(text: str) -> str:
    """Return a text as a string of YAML, whatever it contains: plain ones may be numbers, lists or comments.

    Examples
    --------
    >>> print(_yaml('see "terms": #1'))
    "see \\"terms\\": #1"
    """
    return "".join(c if c.isprintable() else f"\\U{ord(c):08x}" for c in json.dumps(text, ensure_ascii=False))


def versions() -> str:
    """Return the versions that the bytes of a dataset depend on."""
    from importlib.metadata import version

    names = ("scenelang", "numpy", "pillow")
    return ", ".join(
        [*(f"{n} {version(n)}" for n in names), f"Python {platform.python_version()}", platform.platform()]
    )


def _rows(head: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """Return the lines of a Markdown table."""
    cleaned = [[cell.replace("|", "\\|").replace("\n", " ") for cell in row] for row in rows]
    lines = [f"| {' | '.join(head)} |", f"|{'---|' * len(head)}"]
    return lines + [f"| {' | '.join(row)} |" for row in cleaned]


# --- previews --------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Preview:
    """A contact sheet: its file, the samples that it shows, and the failures among them."""

    path: Path
    samples: int
    failures: Sequence[Diagnostic]
    quantities: Sequence[Quantity]

    def __str__(self) -> str:
        lines = [f"wrote {self.path}: {self.samples} samples, {len(self.failures)} failed"]
        for quantity in self.quantities:
            name = f"{quantity.name} ({quantity.note})" if quantity.note else quantity.name
            lines.append(f"  {name}: {quantity.summary()}")
        return "\n".join(lines)

    def data(self) -> dict[str, Any]:
        """Return the preview as JSON data."""
        varied = {quantity.name: dict(quantity.counts) for quantity in self.quantities}
        return {"path": str(self.path), "samples": self.samples, "failures": len(self.failures), "varied": varied}


@typed
def preview_dataset(spec: str | Path, path: str | Path, count: int = 12) -> Preview:
    """Make the first samples of a spec and show them with their labels, and the distributions of varying quantities.

    The distributions are those of the draws of the first 2,000 samples, before filters. Splits by scene are decided by
    the evaluated scene, so their distribution is approximate.

    Parameters
    ----------
    spec : path
        Spec of the dataset.
    path : path
        Image to write: ``.png``, ``.jpg``, ``.jpeg`` or ``.webp``.
    count : int
        Number of samples to make.

    Raises
    ------
    SceneError
        As ``dataset``, and if no sample can be made.
    """
    if not 1 <= count <= MAX_PREVIEW:
        raise UsageError("value", f"a preview shows 1 to {MAX_PREVIEW} samples, not {count}")
    ending = Path(path).suffix.lower()
    if ending not in _MAX_SHEET_PX:
        raise UsageError(
            "value", f"a preview cannot be written as `{Path(path).name}`", f"use {' '.join(_MAX_SHEET_PX)}"
        )
    read = read_spec(spec)
    maker, rows, failures = Maker(read), list[_Row](), list[Diagnostic]()
    for index in range(min(count, read.count)):
        try:
            sample = maker.make(index)
        except SampleFailure as failure:
            failures.append(failure.diagnostic)
            continue
        rows.append(_row(sample.items[0].key, sample.items[0].files))
    if not rows:
        raise SceneError(failures[0].name, failures[0].message, failures[0].hint, failures[0].span)
    quantities = quantities_of(list(_drawn(read)))
    if read.splits is not None and read.splits.by == "scene":
        quantities = [replace(q, note=_APPROXIMATE) if q.name == "split" else q for q in quantities]
    sheet = _sheet(read, rows, quantities)
    if max(sheet.shape) > _MAX_SHEET_PX[ending]:
        raise UsageError(
            "value", f"a sheet of {len(rows)} samples is too large for {ending}", "show fewer, or use .png"
        )
    save_picture(sheet, path)
    return Preview(Path(path), len(rows), tuple(failures), tuple(quantities))


def _drawn(spec: Spec) -> Iterator[dict[str, Any]]:
    """Yield the draws of the first samples without making them: first attempts, and first cameras."""
    for index in range(min(spec.count, _MAX_DRAWN)):
        draw = draw_sample(spec, index)
        if draw is not None:
            view = views_of(spec, draw)[0]
            values = dict(draw.values)
            if isinstance(view, Viewpoint):
                values |= {f"camera.{name}": getattr(view, name) for name in ("azimuth", "elevation", "fov")}
            yield values | {"split": draw.split}


# --- rows of the sheet ---------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Row:
    """Row of the sheet about one image: tiles with titles, and lines of text below, whose words may have colors."""

    tiles: Sequence[tuple[str, Picture]]
    words: Mapping[str, Color]
    lines: Sequence[Sequence[Entry]]

    @property
    def height(self) -> int:
        """Height in pixels, with the gap below."""
        tallest = max(int(picture.shape[0]) for _, picture in self.tiles)
        return _LINE * (1 + len(self.lines)) + tallest + 2 * _GAP


def _row(key: str, files: Mapping[str, bytes]) -> _Row:
    """Return the row of one item."""
    record, arrays = json.loads(files["json"]), {name: decoded(name, files[name]) for name in files}
    color = arrays["color.png"]
    tiles = [(key, _fitted(color, is_smooth=True))]
    if "things" in record:
        tiles.append(("boxes", _with_boxes(color, record)))
    for name in sorted(arrays):
        painted = _painted(name, arrays, record)
        if painted is not None:
            tiles.append((_TITLES.get(name, name.partition(".")[0]), painted))
    lines: list[list[Entry]] = []
    if "instance.png" in files and record.get("things"):
        lines.append(
            [
                ("instances:", None),
                *((instance["word"], instance_color(instance["id"])) for instance in _shown_of(record)),
            ]
        )
    if "caption" in record:
        lines.append([(f"caption: {record['caption']}", None)])
    return _Row(tiles, _words_of(arrays, record), lines)


def _shown_of(record: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Return the records of visible objects, the largest first."""
    return sorted(
        (instance for instance in record["things"] if instance["area"]), key=lambda instance: -int(instance["area"])
    )


def _words_of(arrays: Mapping[str, Any], record: Mapping[str, Any]) -> dict[str, Color]:
    """Return the colors of an image's words, as in its boxes and classes."""
    words = {instance["word"]: word_color(instance["word"]) for instance in record.get("things", ())}
    is_other = "semantic.png" in arrays and (arrays["semantic.png"] == OTHER).any()
    return words | ({_OTHER: word_color(_OTHER)} if is_other else {})


def _painted(name: str, arrays: Mapping[str, Any], record: Mapping[str, Any]) -> Picture | None:
    """Return a file of an item as a tile, None if it is not shown."""
    values = arrays[name]
    if name == "depth.npy":
        return _fitted(depth_picture(values.astype(np.float64)))
    if name == "flow.npy":
        height, width = values.shape[:2]
        return _fitted(flow_picture(Flow(values, np.zeros((height, width, 3), np.float32), arrays["flow_state.png"])))
    if name == "tracks.npz":
        return _with_tracks(arrays["color.png"], values)
    if not name.endswith(".png") or name == "color.png":
        return None
    return _fitted(values if values.ndim == 3 else _numbers_painted(name, values, record))


def _numbers_painted(name: str, values: npt.NDArray[Any], record: Mapping[str, Any]) -> Picture:
    """Return a map of numbers (H, W) in colors; 0 is black."""
    words = {instance["class"]: instance["word"] for instance in record.get("things", ())} | {OTHER: _OTHER}

    def paint(number: int) -> Color:
        """Return the color of a number: by word, by state, or by instance."""
        if name == "semantic.png":
            return word_color(words.get(number, _OTHER))
        return _STATES.get(number, _INK) if name == "flow_state.png" else instance_color(number)

    used, inverse = np.unique(values, return_inverse=True)
    table = np.array([paint(int(n)) if n else (0, 0, 0) for n in used], np.uint8)
    return np.asarray(table[inverse.reshape(-1)].reshape(*values.shape, 3))


def _fitted(picture: npt.NDArray[Any], *, is_smooth: bool = False) -> Picture:
    """Return an image in the size of a tile: small ones are enlarged to whole multiples."""
    modules = require("PIL.Image", "pillow")
    scale = _scale(picture)
    size = [max(1, round(side * scale)) for side in (picture.shape[1], picture.shape[0])]
    how = modules.Resampling.LANCZOS if is_smooth and scale < 1.0 else modules.Resampling.NEAREST
    return np.asarray(modules.fromarray(np.asarray(picture, np.uint8)).resize(size, how), np.uint8)


def _scale(picture: npt.NDArray[Any]) -> float:
    """Return the scale of an image in a tile; small ones are enlarged to whole multiples."""
    scale = _TILE_PX / max(picture.shape[:2])
    return float(math.floor(scale)) if scale > 1.0 else scale


def _with_boxes(color: Picture, record: Mapping[str, Any]) -> Picture:
    """Return a tile with the boxes of objects below the root, and the keypoints: white if they are visible."""
    image = require("PIL.Image", "pillow").fromarray(_fitted(color, is_smooth=True))
    pen = require("PIL.ImageDraw", "pillow").Draw(image)
    scale = _scale(color)
    for instance in record["things"]:
        x, y, width, height = (scale * value for value in instance["bbox"])
        if width and height and (instance["depth"] or len(record["things"]) == 1):
            corner = max(x, x + width - 1), max(y, y + height - 1)
            pen.rectangle((x, y, *corner), outline=word_color(instance["word"]))
    for point in record.get("keypoints", ()):
        if point["visible"]:
            x, y = (scale * value for value in point["point"])
            fill = (255, 255, 255) if point["visible"] == 2 else (128, 128, 128)
            pen.ellipse((x - 2, y - 2, x + 2, y + 2), outline=_INK, fill=fill)
    return np.asarray(image, np.uint8).copy()


def _with_tracks(color: Picture, values: Mapping[str, npt.NDArray[Any]]) -> Picture:
    """Return a tile with the trajectories of the tracked points through all frames."""
    frames = len(values["pixels"])
    tracks = Tracks(values["pixels"] * _scale(color), values["world"], values["state"])
    return with_tracks(_fitted(color, is_smooth=True), tracks, frames - 1, frames)


# --- the contact sheet -----------------------------------------------------------------------------------------------


def _sheet(spec: Spec, rows: Sequence[_Row], quantities: Sequence[Quantity]) -> Picture:
    """Return the sheet: the colors of the words, tiles for each sample, then a histogram for each quantity."""
    columns = max(len(row.tiles) for row in rows)
    chart = (2 * _TILE_PX + _GAP, _TILE_PX)
    width = max(2 * _MARGIN + columns * (_TILE_PX + _GAP), 2 * _MARGIN + 2 * (chart[0] + _GAP))
    per_row = max(1, (width - 2 * _MARGIN) // (chart[0] + _GAP))
    words = {word: color for row in rows for word, color in row.words.items()}
    key = _wrapped([("words:", None), *sorted(words.items())], width - 2 * _MARGIN) if words else []
    top = _MARGIN + _LINE * (1 + len(key)) + _GAP
    charts = top + sum(row.height for row in rows)
    height = charts + -(-len(quantities) // per_row) * (chart[1] + _GAP) + _MARGIN
    modules = require("PIL.Image", "pillow"), require("PIL.ImageDraw", "pillow")
    image = modules[0].new("RGB", (width, height), _PAPER)
    pen = modules[1].Draw(image)
    _text(pen, (_MARGIN, _MARGIN - 2), f"{Path(spec.name).name}: {spec.count:,} samples, {len(rows)} shown", width)
    for i, named in enumerate(key, start=1):
        _entries(pen, named, (_MARGIN, _MARGIN - 2 + i * _LINE), width - 2 * _MARGIN)
    for row in rows:
        for j, (title, picture) in enumerate(row.tiles):
            x = _MARGIN + j * (_TILE_PX + _GAP)
            _text(pen, (x, top), title, _TILE_PX)
            image.paste(modules[0].fromarray(picture), (x, top + _LINE))
        below = top + row.height - 2 * _GAP - _LINE * len(row.lines)
        for i, line in enumerate(row.lines):
            _entries(pen, line, (_MARGIN, below + 2 + i * _LINE), width - 2 * _MARGIN)
        top += row.height
    for k, quantity in enumerate(quantities):
        x, y = _MARGIN + (k % per_row) * (chart[0] + _GAP), charts + (k // per_row) * (chart[1] + _GAP)
        _histogram(pen, quantity, (x, y), chart)
    return np.asarray(image, np.uint8).copy()


def _wrapped(entries: Sequence[Entry], width: int, most: int = _MAX_LINES) -> list[list[Entry]]:
    """Return lines of entries of at most ``width`` pixels; the last of ``most`` gives the number of omitted ones."""
    lines: list[list[Entry]] = [[]]
    used = 0.0
    for number, (text, color) in enumerate(entries):
        entry_width = min(_wide(text, color), width)
        rest = f"and {len(entries) - number} more"
        reserve = _wide(rest, None) if len(lines) == most and number + 1 < len(entries) else 0.0
        if used and used + entry_width + reserve > width:
            if len(lines) == most:
                lines[-1].append((rest, None))
                break
            lines.append([])
            used = 0.0
        lines[-1].append((text, color))
        used += entry_width
    return lines


def _wide(text: str, color: Color | None) -> float:
    """Return the width of an entry with the gap after it."""
    swatch = _LINE if color is not None else 0
    return float(_font().getlength(_plain(text))) + swatch + 2 * _GAP


def _entries(pen: Any, entries: Sequence[Entry], corner: tuple[int, int], width: int) -> None:
    """Draw entries in a line of ``width`` pixels: a swatch of the color, if an entry has one, and the text."""
    (x, y), end = corner, corner[0] + width
    for text, color in _wrapped(entries, width, 1)[0]:
        start = x
        if color is not None:
            pen.rectangle((x, y + 2, x + _LINE - 6, y + _LINE - 4), fill=color, outline=_INK)
            start += _LINE
        _text(pen, (start, y), text, end - start)
        x += round(_wide(text, color))


def _histogram(pen: Any, quantity: Quantity, corner: tuple[int, int], size: tuple[int, int]) -> None:
    """Draw the distribution of a quantity: vertical bars for numbers, horizontal ones for other values."""
    (x, y), (width, height) = corner, size
    bars = quantity.bars()
    most = max((count for _, count in bars), default=1) or 1
    note = f" ({quantity.note})" if quantity.note else ""
    _text(pen, (x, y), f"{quantity.name}{note}: {quantity.summary()}", width)
    top, low = y + _LINE + 2, y + height - _LINE
    if quantity.numbers is None:
        step = max(1, min(_LINE, (low + _LINE - top) // max(1, len(bars))))
        for i, (label, count) in enumerate(bars):
            row = top + i * step
            pen.rectangle((x, row + 1, x + max(1, count * width // most) - 1, row + step - 2), fill=_BAR)
            _text(pen, (x + 3, row - 1), f"{label}: {count}", width)
        return
    wide = width // max(1, len(bars))
    for i, (label, count) in enumerate(bars):
        left = x + i * wide
        if count:
            pen.rectangle((left, low - count * (low - top) // most, left + wide - 2, low - 1), fill=_BAR)
        if i % max(1, -(-40 // max(1, wide))) == 0:
            _text(pen, (left, low + 1), label, wide * max(1, -(-40 // max(1, wide))))


@cache
def _font() -> Any:
    """Return the font of the sheet."""
    return require("PIL.ImageFont", "pillow").load_default(11)


def _plain(text: str) -> str:
    """Return a text without unprintable characters."""
    return "".join(c if c.isprintable() else " " for c in text)


def _text(pen: Any, corner: tuple[int, int], text: str, width: int) -> None:
    """Write a line of text, cut off at ``width`` pixels."""
    font, plain = _font(), _plain(text)
    if font.getlength(plain) > width:
        while plain and font.getlength(plain + "…") > width:
            plain = plain[:-1]
        plain += "…"
    pen.text(corner, plain, fill=_INK, font=font)
