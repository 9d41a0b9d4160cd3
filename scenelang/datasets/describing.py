"""Describes datasets: statistics, the dataset card, and the contact sheet that shows a spec before a large run."""

from __future__ import annotations

import json
import platform
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import require
from scenelang.backends.files import atomic_write
from scenelang.backends.labels.dataset import depth_picture, instance_color, word_color
from scenelang.backends.pictures.camera import Viewpoint
from scenelang.datasets.making import Maker, SampleFailure, decoded
from scenelang.datasets.sampler import draw_sample, views_of
from scenelang.datasets.spec import Spec, read_spec
from scenelang.datasets.store import Plan, Store
from scenelang.grammar.diagnostics import Diagnostic, SceneError, UsageError
from scenelang.grammar.settings import typed

Picture = npt.NDArray[np.uint8]
MAX_PREVIEW = 400
_MAX_DRAWN = 2_000  # samples whose draws are shown
_BARS = 16  # of a histogram
_MAX_BARS = 12  # rows of a table of values
_TILE = 160  # pixels
_GAP, _LINE, _MARGIN = 6, 15, 12
_INK, _PAPER, _BAR = (24, 26, 32), (255, 255, 255), (164, 190, 232)
_SILENT = ("seed",)  # quantities without a table


# --- statistics ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Quantity:
    """Distribution of one quantity: ``numbers`` if all values are numbers, else ``counts`` by value."""

    name: str
    numbers: npt.NDArray[np.float64] | None
    counts: Mapping[str, int]

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
    """Return the distributions of what varies among the ``values`` of samples."""
    found = []
    for name in sorted({name for each in values for name in each}):
        column = [each[name] for each in values if name in each]
        counts = Counter(map(_shown, column))
        if len(counts) > 1 and name not in _SILENT:
            found.append(_quantity(name, column, counts))
    return found


def _quantity(name: str, column: Sequence[Any], counts: Counter[str]) -> Quantity:
    is_number = all(isinstance(value, int | float) and not isinstance(value, bool) for value in column)
    if is_number:
        ordered = sorted(counts.items(), key=lambda pair: float(pair[0]))
        return Quantity(name, np.array(column, np.float64), dict(ordered))
    return Quantity(name, None, dict(counts.most_common()))


def _shown(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(list(value) if isinstance(value, tuple) else value)


# --- the card --------------------------------------------------------------------------------------------------------


def write_card(store: Store, plan: Plan, records: Sequence[Mapping[str, Any]], digest: str) -> None:
    """Write the dataset card, ``README.md``: what the dataset has, how it was made, and how it is read."""
    store.write("README.md", card_of(plan, records, digest).encode("utf-8"))


def card_of(plan: Plan, records: Sequence[Mapping[str, Any]], digest: str) -> str:
    """Return the text of a dataset card; its head is the metadata that Hugging Face reads."""
    splits: Counter[str] = Counter()
    for record in records:
        splits.update({each["split"]: each["items"] for each in record["files"]})
    size = sum(each["bytes"] for record in records for each in record["files"])
    ending = "parquet" if plan.format == "parquet" else "tar"
    head = ["---", f"license: {plan.licence or 'unknown'}", "tags: [synthetic, scenelang]", "configs:"]
    head += ["- config_name: default", "  data_files:"]
    for split in sorted(splits):
        head += [f"  - split: {split}", f'    path: "{split}-*.{ending}"']
    parts = [*head, "---", "", "# A labelled dataset made with scenelang", ""]
    parts += _rows(("split", "pictures"), sorted((name, f"{count:,}") for name, count in splits.items()))
    failures = Counter(each["code"] for record in records for each in record["failures"])
    samples = sum(record["samples"] for record in records)
    facts = [("samples", f"{samples:,} of {plan.count:,}"), ("bytes", f"{size:,}"), ("digest", f"`{digest}`")]
    facts += [("spec", f"`{plan.spec_digest}`"), ("versions", versions())]
    facts += [("failures", ", ".join(f"{code}: {n:,}" for code, n in sorted(failures.items())) or "none")]
    parts += ["", *_rows(("", ""), facts), "", "## Classes", ""]
    shown: Counter[str] = Counter()
    for record in records:
        shown.update(record["shown"])
    parts += _rows(("class", "word", "visible things"), [(str(n), w, f"{shown[w]:,}") for w, n in plan.classes.items()])
    values = [each for record in records for each in record["values"]]
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


def versions() -> str:
    """Return the versions that the bytes of a dataset depend on."""
    from importlib.metadata import version

    names = ("scenelang", "numpy", "pillow")
    return ", ".join(
        [*(f"{n} {version(n)}" for n in names), f"Python {platform.python_version()}", platform.platform()]
    )


def _rows(head: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    clean = lambda cell: cell.replace("|", "\\|").replace("\n", " ")
    lines = [f"| {' | '.join(head)} |", f"|{'---|' * len(head)}"]
    return lines + [f"| {' | '.join(map(clean, row))} |" for row in rows]


# --- the contact sheet -----------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Preview:
    """A contact sheet: its file, the samples that it shows, and the failures among them."""

    path: Path
    samples: int
    failures: Sequence[Diagnostic]
    quantities: Sequence[Quantity]

    def __str__(self) -> str:
        lines = [f"wrote {self.path}: {self.samples} samples, {len(self.failures)} failed"]
        return "\n".join([*lines, *(f"  {each.name}: {each.summary()}" for each in self.quantities)])

    def data(self) -> dict[str, Any]:
        """Return the preview as JSON data."""
        varied = {each.name: dict(each.counts) for each in self.quantities}
        return {"path": str(self.path), "samples": self.samples, "failures": len(self.failures), "varied": varied}


@typed
def preview_dataset(spec: str | Path, path: str | Path, count: int = 12) -> Preview:
    """Make the first samples of a spec and show them with their labels, and the distribution of what varies.

    The distributions are those of the draws of the first 2,000 samples, before filters.

    Parameters
    ----------
    spec : path
        Spec of the dataset.
    path : path
        Picture to write, such as ``preview.png``.
    count : int
        Number of samples to make.

    Raises
    ------
    SceneError
        As ``dataset``, and if no sample can be made.
    """
    if not 1 <= count <= MAX_PREVIEW:
        raise UsageError("value", f"a preview shows 1 to {MAX_PREVIEW} samples, not {count}")
    read = read_spec(spec)
    maker, rows, failures = Maker(read), list[list[tuple[str, Picture]]](), list[Diagnostic]()
    for index in range(min(count, read.count)):
        try:
            sample = maker.make(index)
        except SampleFailure as failure:
            failures.append(failure.diagnostic)
            continue
        rows.append(_tiles(sample.items[0].key, sample.items[0].files))
    if not rows:
        raise SceneError(failures[0].name, failures[0].message, failures[0].hint, failures[0].span)
    quantities = quantities_of(list(_drawn(read)))
    sheet = _sheet(read, rows, quantities)
    with atomic_write(path) as temporary:
        require("PIL.Image", "pillow").fromarray(sheet).save(temporary, "PNG")
    return Preview(Path(path), len(rows), tuple(failures), tuple(quantities))


def _drawn(spec: Spec) -> Iterator[dict[str, Any]]:
    """Yield what is drawn for the first samples, without making them: first attempts, and first cameras."""
    for index in range(min(spec.count, _MAX_DRAWN)):
        draw = draw_sample(spec, index)
        if draw is not None:
            view = views_of(spec, draw)[0]
            found = dict(draw.values)
            if isinstance(view, Viewpoint):
                found |= {f"camera.{name}": getattr(view, name) for name in ("azimuth", "elevation", "fov")}
            yield found | {"split": draw.split}


def _tiles(key: str, files: Mapping[str, bytes]) -> list[tuple[str, Picture]]:
    """Return the pictures of one item with their titles."""
    record = json.loads(files["json"])
    color = decoded("color.png", files["color.png"])
    tiles = [(key, color)]
    if "things" in record:
        tiles.append(("boxes", _with_boxes(color, record)))
    for name in sorted(files):
        if name.endswith(".png") and name != "color.png":
            tiles.append((name.removesuffix(".png"), _painted(name, decoded(name, files[name]), record)))
        elif name == "depth.npy":
            tiles.append(("depth", depth_picture(decoded(name, files[name]).astype(np.float64))))
    return tiles


def _painted(name: str, values: npt.NDArray[Any], record: Mapping[str, Any]) -> Picture:
    if values.ndim == 3:
        return np.asarray(values, np.uint8)
    used, inverse = np.unique(values, return_inverse=True)
    words = {thing["class"]: thing["word"] for thing in record.get("things", ())}
    paint = (lambda n: word_color(words.get(n, "other"))) if name == "semantic.png" else instance_color
    table = np.array([paint(int(n)) if n else (0, 0, 0) for n in used], np.uint8)
    return np.asarray(table[inverse.reshape(-1)].reshape(*values.shape, 3))


def _with_boxes(color: Picture, record: Mapping[str, Any]) -> Picture:
    image = require("PIL.Image", "pillow").fromarray(color)
    pen = require("PIL.ImageDraw", "pillow").Draw(image)
    for thing in record["things"]:
        x, y, width, height = thing["bbox"]
        if width and height and thing["depth"]:
            pen.rectangle((x, y, x + width - 1, y + height - 1), outline=word_color(thing["word"]))
    for point in record.get("keypoints", ()):
        if point["visible"]:
            x, y = point["point"]
            pen.ellipse(
                (x - 2, y - 2, x + 2, y + 2), outline=(255, 255, 255) if point["visible"] == 2 else (128, 128, 128)
            )
    return np.asarray(image, np.uint8).copy()


def _sheet(spec: Spec, rows: Sequence[Sequence[tuple[str, Picture]]], quantities: Sequence[Quantity]) -> Picture:
    """Return the sheet: a row of tiles for each sample, then a histogram for each quantity."""
    columns = max(len(row) for row in rows)
    chart = (2 * _TILE + _GAP, _TILE)
    width = max(2 * _MARGIN + columns * (_TILE + _GAP), 2 * _MARGIN + 2 * (chart[0] + _GAP))
    per_row = max(1, (width - 2 * _MARGIN) // (chart[0] + _GAP))
    top = _MARGIN + _LINE + _GAP
    tallest = max(min(_TILE, _TILE * picture.shape[0] // picture.shape[1]) for row in rows for _, picture in row)
    row_height = tallest + _LINE + _GAP
    charts = -(-len(quantities) // per_row)
    height = top + len(rows) * row_height + charts * (chart[1] + _GAP) + _MARGIN
    modules = require("PIL.Image", "pillow"), require("PIL.ImageDraw", "pillow")
    image = modules[0].new("RGB", (width, height), _PAPER)
    pen = modules[1].Draw(image)
    _text(pen, (_MARGIN, _MARGIN - 2), f"{Path(spec.name).name}: {spec.count:,} samples, {len(rows)} shown", width)
    for i, row in enumerate(rows):
        for j, (title, picture) in enumerate(row):
            x, y = _MARGIN + j * (_TILE + _GAP), top + i * row_height
            _text(pen, (x, y), title, _TILE)
            tile = modules[0].fromarray(picture)
            tile.thumbnail((_TILE, _TILE), modules[0].Resampling.NEAREST if j else modules[0].Resampling.LANCZOS)
            image.paste(tile, (x, y + _LINE))
    for k, quantity in enumerate(quantities):
        x = _MARGIN + (k % per_row) * (chart[0] + _GAP)
        _histogram(pen, quantity, (x, top + len(rows) * row_height + (k // per_row) * (chart[1] + _GAP)), chart)
    return np.asarray(image, np.uint8).copy()


def _histogram(pen: Any, quantity: Quantity, corner: tuple[int, int], size: tuple[int, int]) -> None:
    """Draw the distribution of a quantity: vertical bars for numbers, horizontal ones for other values."""
    (x, y), (width, height) = corner, size
    bars = quantity.bars()
    most = max((count for _, count in bars), default=1) or 1
    _text(pen, (x, y), f"{quantity.name}: {quantity.summary()}", width)
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


def _text(pen: Any, corner: tuple[int, int], text: str, width: int) -> None:
    """Write a line of text, cut off at ``width`` pixels."""
    font = require("PIL.ImageFont", "pillow").load_default(11)
    plain = "".join(c if c.isprintable() else " " for c in text)
    if font.getlength(plain) > width:
        while plain and font.getlength(plain + "…") > width:
            plain = plain[:-1]
        plain += "…"
    pen.text(corner, plain, fill=_INK, font=font)
