"""Records as the paper's tables."""

from __future__ import annotations

from typing import Any

import pytest

from scenelang.evaluation.running import MetricRecord
from scenelang.evaluation.tables import as_data, as_latex, as_markdown, as_text, tables_of


def record(method: str, metric: str, group: str, value: float, place: str = "a", **more: Any) -> MetricRecord:
    return MetricRecord(place, method, metric, "", group, "p", {"value": value, **more})


RECORDS = [
    record("draft", "clip", "numeric", 0.3, "a"),
    record("draft", "clip", "numeric", 0.34, "b"),
    record("draft", "count", "numeric", 1.0, "a"),
    record("draft", "count", "numeric", 0.0, "b"),
    record("draft", "clip", "generic", 0.25, "c"),
    record("draft", "alignment", "numeric", 62.5, "a"),
    record("spl_ats", "clip", "generic", 0.31, "c"),
    record("draft", "clip", "4d", 0.29, "d"),
    record("draft", "dynamic", "4d", 0.0375, "d", pixels=19.2, is_dynamic=True),
    record("draft", "dynamic", "4d", 0.0125, "e", pixels=6.4, is_dynamic=False),
    record("draft", "lpips", "generic", 0.5, "c"),
    record("draft", "lpips", "numeric", 0.7, "a"),
]

TEXT = """\
Text-prompted 3D generation

                      Numeric prompts                        Generic prompts
Method                  Alignment ↑         CLIP ↑  Count ↑    Alignment ↑         CLIP ↑
--------------------  -------------  -------------  -------  -------------  -------------
GraphDreamer (paper)    3.56 ± 7.38  0.297 ± 0.085     0.11  15.75 ± 20.39  0.230 ± 0.097
MVDream (paper)       10.79 ± 12.83  0.312 ± 0.046     0.11  35.13 ± 31.90  0.328 ± 0.031
Ours (paper)          85.65 ± 13.71  0.351 ± 0.051     1.00  52.13 ± 26.83  0.328 ± 0.030
--------------------  -------------  -------------  -------  -------------  -------------
draft                  62.50 ± 0.00  0.320 ± 0.020     0.50              -  0.250 ± 0.000
spl_ats                           -              -        -              -  0.310 ± 0.000

Text-prompted 4D generation

Method                             CLIP ↑  Dynamic ↑  Pixels ↑  VBench ↑
---------------------------------  ------  ---------  --------  --------
4D-fy (paper)                       0.352       0.2%         -         -
4D-fy (w/ prompt variant) (paper)   0.354       0.6%         -         -
Ours (paper)                        0.341       5.9%         -         -
---------------------------------  ------  ---------  --------  --------
draft                               0.290       2.5%     12.80      0.50

Image-prompted generation

Method                LPIPS ↓
--------------------  -------
GraphDreamer (paper)    0.811
Ours (paper)            0.681
--------------------  -------
draft                   0.600"""

MARKDOWN = """\
**Image-prompted generation**

| Method | LPIPS ↓ |
| --- | ---: |
| GraphDreamer (paper) | 0.811 |
| Ours (paper) | 0.681 |
| draft | 0.600 |"""

LATEX = r"""% Text-prompted 3D generation
\begin{tabular}{lccccc}
\toprule
 & \multicolumn{3}{c}{Numeric prompts} & \multicolumn{2}{c}{Generic prompts} \\
\cmidrule(lr){2-4} \cmidrule(lr){5-6}
Methods & Alignment ($\uparrow$) & CLIP ($\uparrow$) & Count ($\uparrow$) & Alignment ($\uparrow$) & CLIP ($\uparrow$) \\
\midrule
GraphDreamer (paper) & $3.56 \pm 7.38$ & $0.297 \pm 0.085$ & $0.11$ & $15.75 \pm 20.39$ & $0.230 \pm 0.097$ \\
MVDream (paper) & $10.79 \pm 12.83$ & $0.312 \pm 0.046$ & $0.11$ & $35.13 \pm 31.90$ & $0.328 \pm 0.031$ \\
Ours (paper) & $85.65 \pm 13.71$ & $0.351 \pm 0.051$ & $1.00$ & $52.13 \pm 26.83$ & $0.328 \pm 0.030$ \\
\midrule
draft & $62.50 \pm 0.00$ & $0.320 \pm 0.020$ & $0.50$ & - & $0.250 \pm 0.000$ \\
spl\_ats & - & - & - & - & $0.310 \pm 0.000$ \\
\bottomrule
\end{tabular}"""


def test_tables_as_text() -> None:
    assert "\n\n".join(map(as_text, tables_of(RECORDS))) == TEXT


def test_tables_as_markdown_and_latex() -> None:
    text, moving, image = tables_of(RECORDS)
    assert as_markdown(image) == MARKDOWN
    assert as_latex(text) == LATEX
    assert r"$2.5\%$" in as_latex(moving)
    assert "| Method | Numeric prompts: Alignment ↑ |" in as_markdown(text)


def test_names_of_methods_are_only_text() -> None:
    (table,) = tables_of([record(r"a|<b>&\%{x}", "lpips", "generic", 0.5)])
    assert r"a\|\<b\>&\\%\{x\}" in as_markdown(table)
    assert r"a|<b>\&\textbackslash{}\%\{x\}" in as_latex(table)


def test_tables_as_data() -> None:
    text, *_ = map(as_data, tables_of(RECORDS))
    assert text["columns"][1] == {"heading": "Numeric prompts", "title": "CLIP", "metric": "clip", "unit": ""}
    ours = next(row for row in text["rows"] if row["method"] == "draft")
    assert not ours["paper"]
    assert ours["cells"][1] == {"value": pytest.approx(0.32), "deviation": pytest.approx(0.02), "scenes": 2}
    assert text["rows"][2]["cells"][0] == {"value": 85.65, "deviation": 13.71, "scenes": 0}


def test_only_tables_with_something_in_them() -> None:
    assert tables_of([]) == []
    assert [table.paper.name for table in tables_of([record("m", "lpips", "4d", 0.1)])] == ["image"]
