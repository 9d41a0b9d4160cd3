"""Results of benchmark runs: figures by mode, tables in Markdown and as data, comparisons, and a contact sheet."""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scenelang.backends.files import atomic_write
from scenelang.bench.scoring import Score, scene_of
from scenelang.bench.tasks import GEOMETRY, KEEP, BenchTask
from scenelang.bench.trials import BenchRun, Trial
from scenelang.grammar.diagnostics import CODES, SceneError

if TYPE_CHECKING:
    import numpy.typing as npt

_Z = 1.959964  # of the normal distribution, for 95 %


@dataclass(frozen=True, slots=True)
class BenchFigure:
    """A mean over tasks or answers; ``low`` and ``high`` bound its 95 % confidence interval if it is a share."""

    value: float
    count: int
    low: float | None = None
    high: float | None = None


@dataclass(frozen=True, slots=True)
class DiagnosticRecord:
    """How often an error occurred in answers that a repair followed, and how often the next answer was free of it."""

    code: str
    title: str
    occurred: int
    repaired: int

    @property
    def failed(self) -> int:
        return self.occurred - self.repaired


@dataclass(frozen=True, slots=True)
class ModeResults:
    """Figures of one mode.

    ``figures`` by name are in the order of the table; ``groups`` has pass@1 by group of tasks, ``predicates`` the share
    that holds by relation, ``diagnostics`` are ranked by failures.
    """

    mode: str
    figures: Mapping[str, BenchFigure | None]
    groups: Mapping[str, BenchFigure]
    predicates: Mapping[str, BenchFigure]
    diagnostics: tuple[DiagnosticRecord, ...]


def wilson(share: float, count: int) -> tuple[float, float]:
    """Return the 95 % confidence interval of a share of ``count`` independent tasks (Wilson's score interval)."""
    if not count:
        return 0.0, 1.0
    z2 = _Z * _Z
    middle = (share + z2 / (2 * count)) / (1 + z2 / count)
    half = _Z / (1 + z2 / count) * math.sqrt(share * (1 - share) / count + z2 / (4 * count * count))
    return max(0.0, middle - half), min(1.0, middle + half)


def pass_at(k: int, count: int, passed: int) -> float:
    """Return the probability that one of ``k`` samples passes, estimated without bias from ``passed`` of ``count``
    (Chen et al., "Evaluating Large Language Models Trained on Code", 2021)."""
    if count - passed < k:
        return 1.0
    return 1.0 - math.prod((count - passed - i) / (count - i) for i in range(k))


def _share(values: Sequence[float]) -> BenchFigure | None:
    """Return the mean of values from 0 to 1 with its interval; the values are of different tasks."""
    if not values:
        return None
    mean = math.fsum(values) / len(values)
    return BenchFigure(mean, len(values), *wilson(mean, len(values)))


def _mean(values: Sequence[float]) -> BenchFigure | None:
    return BenchFigure(math.fsum(values) / len(values), len(values)) if values else None


def _by_task(trials: Iterable[Trial]) -> dict[str, list[Trial]]:
    by_task: dict[str, list[Trial]] = defaultdict(list)
    for trial in trials:
        by_task[trial.task].append(trial)
    return by_task


def results_of(trials: Sequence[Trial], tasks: Sequence[BenchTask]) -> list[ModeResults]:
    """Return the figures of each mode, in the order of the trials."""
    modes = dict.fromkeys(trial.mode for trial in trials)
    return [_mode_results(mode, [t for t in trials if t.mode == mode], tasks) for mode in modes]


def _mode_results(mode: str, trials: Sequence[Trial], tasks: Sequence[BenchTask]) -> ModeResults:
    groups = dict.fromkeys(trial.group for trial in trials)
    passed = {group: _passes([t for t in trials if t.group == group], lambda t: t.passed) for group in groups}
    return ModeResults(
        mode,
        _figures(trials),
        {group: share for group, share in passed.items() if share is not None},
        _predicates(trials, {task.name: task for task in tasks}),
        _diagnostics(trials),
    )


def _passes(trials: Iterable[Trial], holds: Callable[[Trial], bool], k: int = 1) -> BenchFigure | None:
    """Return the mean over tasks of pass@k."""
    return _share([
        pass_at(k, len(each), sum(map(holds, each))) for each in _by_task(trials).values() if len(each) >= k
    ])  # fmt: skip


def _figures(trials: Sequence[Trial]) -> dict[str, BenchFigure | None]:
    most = max((len(each) for each in _by_task(trials).values()), default=1)
    repairs = [float(sum(a.purpose == "repair" for a in trial.attempts)) for trial in trials]
    several = {f"pass@{most}": _passes(trials, lambda t: t.passed, most)} if most > 1 else {}
    return {
        "valid first answers": _passes(trials, lambda t: t.first is not None),
        "passes at the first answer": _passes(trials, lambda t: t.passed_first),
        "pass@1": _passes(trials, lambda t: t.passed),
        **several,
        "repairs": _mean(repairs),
        "input tokens": _mean([float(sum(a.sent for a in trial.attempts)) for trial in trials]),
        "output tokens": _mean([float(sum(a.answered for a in trial.attempts)) for trial in trials]),
        "dollars": _mean([math.fsum(a.cost for a in trial.attempts) for trial in trials]),
        "seconds": _mean([math.fsum(a.seconds for a in trial.attempts) for trial in trials]),
        "scenes with collisions": _share(_by_scene(trials, lambda s: s.collides)),
        "scenes with floating parts": _share(_by_scene(trials, lambda s: s.floats)),
        "stable scenes": _share(_by_scene(trials, lambda s: s.stable)),
        "edit locality": _share(_by_scene(trials, lambda s: s.locality)),
    }


def _by_scene(trials: Sequence[Trial], value: Callable[[Score], float | None]) -> list[float]:
    """Return the means of a property of the scenes of each task, where it is known."""
    known = [
        [float(number) for trial in each if trial.final is not None and (number := value(trial.final)) is not None]
        for each in _by_task(trials).values()
    ]
    return [math.fsum(values) / len(values) for values in known if values]


def _predicates(trials: Sequence[Trial], tasks: Mapping[str, BenchTask]) -> dict[str, BenchFigure]:
    """Return for each relation the share of its declarations that hold; a trial without a scene fails all of its
    task's."""
    held: dict[str, list[float]] = defaultdict(list)
    for trial in trials:
        task = tasks[trial.task]
        for number, declaration in enumerate(task.declarations):
            holds = trial.final is not None and trial.final.reasons[number] is None
            held[declaration.relation].append(float(holds))
        if task.keep:
            held[KEEP].append(float(trial.final is not None and trial.final.locality == 1.0))
        held[GEOMETRY].append(float(trial.final is not None and not trial.final.warnings))
    shares = {name: _share(values) for name, values in sorted(held.items())}
    return {name: share for name, share in shares.items() if share is not None}


def _diagnostics(trials: Sequence[Trial]) -> tuple[DiagnosticRecord, ...]:
    occurred, repaired = Counter[str](), Counter[str]()
    for trial in trials:
        for attempt, later in zip(trial.attempts, trial.attempts[1:]):
            if later.purpose == "repair":
                occurred.update(attempt.codes)
                repaired.update(code for code in attempt.codes if code not in later.codes)
    titles = {diagnostic.code: diagnostic.why for diagnostic in CODES.values()}
    records = [DiagnosticRecord(code, titles.get(code, ""), occurred[code], repaired[code]) for code in occurred]
    return tuple(sorted(records, key=lambda r: (-r.failed, -r.occurred, r.code)))


# --- tables ----------------------------------------------------------------------------------------------------------

_PERCENT = ("valid", "pass", "scenes", "stable", "edit")


def _cell(name: str, estimate: BenchFigure | None) -> str:
    if estimate is None:
        return "-"
    if estimate.low is not None and estimate.high is not None:
        return f"{100 * estimate.value:.1f} % [{100 * estimate.low:.0f}, {100 * estimate.high:.0f}]"
    digits = {"dollars": 4, "repairs": 2, "seconds": 1}.get(name, 0)
    return f"{estimate.value:,.{digits}f}"


def _markdown(header: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    lines = [header, ["---"] + ["---:"] * (len(header) - 1), *rows]
    return [f"| {' | '.join(line)} |" for line in lines]


def markdown(results: Sequence[ModeResults], title: str = "") -> str:
    """Return the tables of a run in Markdown: figures, groups, predicates, diagnostics."""
    modes = [result.mode for result in results]
    lines = [f"# {title}", ""] if title else []
    names = list(dict.fromkeys(name for result in results for name in result.figures))
    rows = [[name, *(_cell(name, r.figures.get(name)) for r in results)] for name in names]
    lines += _markdown(["figure", *modes], rows)
    for heading, part in (("pass@1 by group", "groups"), ("predicates that hold", "predicates")):
        parts: list[Mapping[str, BenchFigure]] = [getattr(result, part) for result in results]
        listed = sorted(dict.fromkeys(name for each in parts for name in each))
        lines += ["", *_markdown([heading, *modes], ([n, *(_cell(n, each.get(n)) for each in parts)] for n in listed))]
    for result in results:
        if result.diagnostics:
            header = [f"errors repaired in {result.mode}", "occurred", "gone in the next answer", "failed"]
            diagnostics = result.diagnostics
            cells = ([f"{r.code} {r.title}", str(r.occurred), str(r.repaired), str(r.failed)] for r in diagnostics)
            lines += ["", *_markdown(header, cells)]
    lines += [
        "",
        "Shares have 95 % confidence intervals (Wilson) over tasks, of predicates over declarations.",
        "",
    ]
    return "\n".join(lines)


def results_data(results: Sequence[ModeResults]) -> dict[str, Any]:
    """Return the figures as JSON data."""
    return {result.mode: asdict(result) for result in results}


# --- comparison ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class BenchComparison:
    """Two runs on the tasks that both have, in one mode.

    ``gained`` and ``lost`` are the trials that pass in only one of them, ``p_value`` that of McNemar's exact test.
    """

    mode: str
    before: ModeResults
    after: ModeResults
    gained: tuple[str, ...]
    lost: tuple[str, ...]
    p_value: float


def compared(before: Sequence[Trial], after: Sequence[Trial], tasks: Sequence[BenchTask]) -> list[BenchComparison]:
    """Compare two runs by the trials that both have. Raises SceneError if they share none."""
    first, second = ({trial.key: trial for trial in trials} for trials in (before, after))
    shared = [key for key in first if key in second]
    if not shared:
        raise SceneError("run", "the two runs have no task and mode in common")
    comparisons = []
    for mode in dict.fromkeys(key[1] for key in shared):
        keys = [key for key in shared if key[1] == mode]
        a, b = [first[key] for key in keys], [second[key] for key in keys]
        gained = tuple(_named(y) for x, y in zip(a, b) if y.passed and not x.passed)
        lost = tuple(_named(y) for x, y in zip(a, b) if x.passed and not y.passed)
        p_value = mcnemar(len(gained), len(lost))
        comparisons.append(
            BenchComparison(mode, _mode_results(mode, a, tasks), _mode_results(mode, b, tasks), gained, lost, p_value)
        )
    return comparisons


def _named(trial: Trial) -> str:
    return trial.task if trial.sample == 1 else f"{trial.task} ({trial.sample})"


def mcnemar(gained: int, lost: int) -> float:
    """Return the two-sided p value of McNemar's exact test: that of a fair coin for ``gained`` against ``lost``."""
    count = gained + lost
    tail = sum(math.comb(count, i) for i in range(min(gained, lost) + 1)) / 2.0**count
    return min(1.0, 2.0 * tail)


def comparison_markdown(comparisons: Sequence[BenchComparison]) -> str:
    """Return a comparison in Markdown: each figure before, after, and its change."""
    lines: list[str] = []
    for each in comparisons:
        rows = []
        for name in dict.fromkeys((*each.before.figures, *each.after.figures)):
            a, b = each.before.figures.get(name), each.after.figures.get(name)
            rows.append([name, _cell(name, a), _cell(name, b), _change(a, b)])
        lines += _markdown([each.mode, "before", "after", "change"], rows)
        lines += ["", f"gained: {', '.join(each.gained) or 'none'}", f"lost: {', '.join(each.lost) or 'none'}"]
        lines += [f"p = {each.p_value:.3g} (McNemar's exact test)", ""]
    return "\n".join(lines)


def _change(before: BenchFigure | None, after: BenchFigure | None) -> str:
    if before is None or after is None:
        return "-"
    difference = after.value - before.value
    if before.low is not None:
        return f"{100 * difference:+.1f} points"
    return f"{100 * difference / before.value:+.1f} %" if before.value else f"{difference:+.4g}"


# --- contact sheet ---------------------------------------------------------------------------------------------------

_TILE, _LABEL, _MARGIN, _COLUMNS = 192, 18, 6, 8
_GOOD, _BAD, _NONE = "#1a7f37", "#cf222e", "#8c959f"
_MAX_TILES = 400


def save_contact_sheet(run: BenchRun, trials: Sequence[Trial], path: Path) -> int:
    """Draw the scene of each trial, framed in green if it passes and in red if not, gray where there is none.

    Returns the number of pictures. At most 400 trials are drawn.
    """
    from PIL import Image

    shown = trials[:_MAX_TILES]
    columns = max(1, min(_COLUMNS, len(shown)))
    rows = max(1, math.ceil(len(shown) / columns))
    step = _TILE + 2 * _MARGIN
    sheet = Image.new("RGB", (columns * step, rows * (step + _LABEL)), "white")
    for number, trial in enumerate(shown):
        corner = (number % columns * step, number // columns * (step + _LABEL))
        _paste(sheet, corner, trial, _picture(run.program_path(trial.key), trial))
    with atomic_write(path) as temporary:
        sheet.save(temporary, "PNG")
    return len(shown)


def _picture(path: Path, trial: Trial) -> npt.NDArray[Any] | None:
    from scenelang.inference.steps import picture

    if trial.final is None:
        return None
    try:
        scene = scene_of(path.read_text("utf-8"))
        frame = len(scene.frames) // 2 if scene.animated else None
        return picture(scene, "azimuth=30,elevation=25", frame, _TILE)
    except (OSError, SceneError):
        return None


def _paste(sheet: Any, corner: tuple[int, int], trial: Trial, pixels: npt.NDArray[Any] | None) -> None:
    from PIL import Image, ImageDraw, ImageFont

    x, y = corner
    color = _GOOD if trial.passed else _BAD if trial.final is not None else _NONE
    draw = ImageDraw.Draw(sheet)
    draw.rectangle((x, y, x + _TILE + 2 * _MARGIN - 1, y + _TILE + 2 * _MARGIN - 1), fill=color)
    tile = Image.fromarray(pixels) if pixels is not None else Image.new("RGB", (_TILE, _TILE), "#f0f0f0")
    sheet.paste(tile, (x + _MARGIN, y + _MARGIN))
    font = ImageFont.load_default(11)
    label = f"{trial.task} {trial.mode}"
    while label and draw.textlength(label, font=font) > _TILE + _MARGIN:
        label = label[:-2]
    draw.text((x + _MARGIN, y + _TILE + 2 * _MARGIN + 2), label, fill=color, font=font)
