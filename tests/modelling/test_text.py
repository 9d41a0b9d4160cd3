"""Text: the bundled font, font files, kerning and alignment."""

from __future__ import annotations

import io
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from fontTools.fontBuilder import FontBuilder
from fontTools.misc.psCharStrings import T2CharString
from fontTools.pens.t2CharStringPen import T2CharStringPen
from fontTools.pens.ttGlyphPen import TTGlyphPen
from fontTools.ttLib import TTFont, newTable
from fontTools.ttLib.tables._k_e_r_n import KernTable_format_0
from hypothesis import given, settings
from hypothesis import strategies as st
from support import value

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.runtime.procedures import call_builtin
from scenelang.interpreter.runtime.runtime import Runtime
from scenelang.interpreter.scene.modelling import outlines
from scenelang.interpreter.scene.modelling.contours import area_of
from scenelang.interpreter.values.values import Keyword, list_items
from scenelang.stdlib.library import build_library

FloatArray = npt.NDArray[np.float64]
Contours = Callable[[str], list[FloatArray]]
Numbers = Callable[[str], float]
Refuses = Callable[[str, str], str]
BUNDLED = Path(outlines.__file__).parent / "fonts" / "DejaVuSans.ttf"


def box(contours: list[FloatArray]) -> FloatArray:
    points = np.concatenate(contours)
    return np.array([points.min(axis=0), points.max(axis=0)])


# --- the bundled font ------------------------------------------------------------------------------------------------


def test_the_bundled_font_is_small_and_has_its_licence() -> None:
    assert BUNDLED.stat().st_size < 250_000
    assert "Bitstream Vera" in BUNDLED.with_name("DejaVuSans-LICENSE.txt").read_text("utf-8")


def test_every_character_of_the_bundled_font() -> None:
    face, font = outlines.bundled(), TTFont(BUNDLED)
    wanted = font.getBestCmap()
    assert {"A", "ä", "Ω", "ж", "→", "∑", "“"} <= {chr(code) for code in wanted}
    for code in (*range(0, 0x3000, 3), 0x1D400):
        number = face.number(chr(code))
        assert number == (font.getGlyphID(wanted[code]) if code in wanted else 0), hex(code)
        if number:
            assert sum(map(area_of, face.glyph(number).contours)) >= 0.0


def test_kerning_is_that_of_the_table() -> None:
    face, font = outlines.bundled(), TTFont(BUNDLED)
    (table,) = font["GPOS"].table.LookupList.Lookup[0].SubTable
    names = font.getGlyphOrder()
    for left in range(0, len(names), 5):
        for right in range(0, len(names), 37):
            wanted = 0
            if names[left] in table.Coverage.glyphs:
                classes = (
                    each.classDefs.get(names[i], 0) for each, i in ((table.ClassDef1, left), (table.ClassDef2, right))
                )
                record = table.Class1Record[next(classes)].Class2Record[next(classes)].Value1
                wanted = getattr(record, "XAdvance", 0) if record else 0
            assert face.kerning(left, right) == wanted / 2048.0


# --- text ------------------------------------------------------------------------------------------------------------


def test_letters_have_their_contours(contours: Contours) -> None:
    assert len(contours('(text-outline "B")')) == 3
    assert len(contours('(text-outline "i o")')) == 4
    assert contours('(text-outline " \n ")') == []
    assert [area_of(each) > 0.0 for each in contours('(text-outline "O")')] == [True, False]


def test_combined_characters_are_composed(contours: Contours) -> None:
    assert np.array_equal(box(contours('(text-outline "\u00e9")')), box(contours('(text-outline "e\u0301")')))


def test_size_spacing_and_lines(contours: Contours) -> None:
    one = box(contours('(text-outline "Hi")'))
    assert np.allclose(box(contours('(text-outline "Hi" :size 3)')), 3.0 * one)
    assert np.allclose(box(contours('(text-outline "Hi" :spacing .5)'))[1] - one[1], [0.5, 0.0])
    assert np.allclose(box(contours('(text-outline "\nHi" :line-height 2)')) - one, [0.0, -2.0])


def test_alignment(contours: Contours) -> None:
    left, center, right = (
        box(contours(f'(text-outline "HH\nH" :align :{each})')) for each in ("left", "center", "right")
    )
    assert 0.0 < left[0, 0] < 0.2
    assert center[0, 0] == pytest.approx(-center[1, 0], abs=0.01)
    assert right[1, 0] == pytest.approx(-left[0, 0], abs=0.01)


def test_kerning_moves_letters_together(contours: Contours) -> None:
    pair, apart = (box(contours(f'(text-outline "{each}")'))[1, 0] for each in ("AV", "HV"))
    widths = [outlines.bundled().glyph(outlines.bundled().number(each)).advance for each in "AH"]
    assert pair - apart == pytest.approx(widths[0] - widths[1] - 131.0 / 2048.0)


def test_text_is_a_solid_with_its_back_at_zero(number: Numbers) -> None:
    assert value('(entity-word (text "Ada"))') == "text"
    text = '(text "Ada" :size 2 :depth .5)'
    assert np.allclose(
        [value(f"(ref ({each} {text}) 2)") for each in ("compute-shape-min", "compute-shape-max")], [0, 0.5]
    )
    assert number(f"(volume {text})") == pytest.approx(0.5 * number('(profile-area (text-outline "Ada" :size 2))'))
    assert value('(ref (compute-shape-max (text "Ada" :size 2)) 2)') == 0.4


@pytest.mark.parametrize(
    ("name", "expression", "part"),
    [
        ("value", '(text-outline "a\u732b\U0001f600b")', 'no glyph for "\u732b" (U+732B), "\U0001f600" (U+1F600)'),
        ("value", '(text-outline "a\u0007")', "no glyph for U+0007"),
        ("value", '(text " ")', "visible characters"),
        ("value", '(text "a" :align :middle)', "`:left`, `:center`, `:right`"),
        ("value", '(text "a" :size 0)', "positive"),
        ("value", '(text "a" :depth -1)', "positive"),
        ("size", '(text-outline (string-pad "a" 20000))', "limit of 10,000"),
        ("file", '(text "a" :font "a.ttf")', "disabled here"),
    ],
)
def test_wrong_text(refuses: Refuses, name: str, expression: str, part: str) -> None:
    assert part in refuses(name, expression)


# --- font files ------------------------------------------------------------------------------------------------------


def draw_square(pen: Any, size: int = 500) -> None:
    pen.moveTo((0, 0))
    for corner in ((0, size), (size, size), (size, 0)):
        pen.lineTo(corner)
    pen.closePath()


def builder(is_truetype: bool) -> FontBuilder:
    made = FontBuilder(1000, isTTF=is_truetype)
    made.setupGlyphOrder([".notdef", "A", "B"])
    made.setupCharacterMap({0x41: "A", 0x42: "B", 0x1F600: "A"})
    return made


def finish(made: FontBuilder) -> FontBuilder:
    made.setupHorizontalMetrics(dict.fromkeys((".notdef", "A", "B"), (1000, 0)))
    made.setupHorizontalHeader(ascent=800, descent=-200)
    made.setupNameTable({"familyName": "Test", "styleName": "Regular"})
    made.setupOS2()
    made.setupPost()
    return made


def truetype() -> FontBuilder:
    made = builder(True)
    pens = {name: TTGlyphPen({".notdef": None, "A": None, "B": None}) for name in (".notdef", "A", "B")}
    draw_square(pens["A"])
    pens["B"].addComponent("A", (1, 0, 0, 1, 0, 0))
    pens["B"].addComponent("A", (0.5, 0, 0, 0.5, 600, 0))
    made.setupGlyf({name: pen.glyph() for name, pen in pens.items()})
    made.setupHorizontalMetrics(dict.fromkeys(pens, (1000, 0)))
    return made


def postscript() -> FontBuilder:
    made = builder(False)
    programs = {}
    for name in (".notdef", "A", "B"):
        pen = T2CharStringPen(1000, None)
        if name != ".notdef":
            pen.moveTo((0, 0))
            pen.curveTo((0, 300), (200, 500), (500, 500))
            pen.lineTo((500, 0))
            pen.closePath()
        programs[name] = pen.getCharString()
    made.setupCFF("Test-Regular", {}, programs, {})
    made.setupHorizontalMetrics(dict.fromkeys(programs, (1000, 0)))
    return made


def data_of(made: FontBuilder) -> bytes:
    out = io.BytesIO()
    made.save(out)
    return out.getvalue()


def areas(face: outlines.Typeface, text: str) -> list[float]:
    return [sum(map(area_of, face.glyph(face.number(each)).contours)) for each in text]


def test_truetype_and_its_components() -> None:
    face = outlines.Typeface(data_of(truetype()), "test")
    assert np.allclose(areas(face, "AB\U0001f600"), [0.25, 0.3125, 0.25])
    assert face.number("C") == 0


def test_cff() -> None:
    face = outlines.Typeface(data_of(postscript()), "test")
    assert areas(face, "A")[0] == pytest.approx(0.25 - 0.0425, abs=0.01)


def test_old_kerning() -> None:
    made = truetype()
    made.font["kern"] = table = newTable("kern")
    sub = KernTable_format_0()
    sub.coverage, sub.kernTable = 1, {("A", "B"): -120, ("B", "A"): 30}
    table.version, table.kernTables = 0, [sub]
    face = outlines.Typeface(data_of(made), "test")
    assert face.kerning(1, 2) == -0.12
    assert face.kerning(2, 1) == 0.03
    assert face.kerning(1, 1) == 0.0


def test_pairs_of_the_feature_kern() -> None:
    made = truetype()
    made.addOpenTypeFeatures("feature kern { pos A B -100; pos B A 40; } kern;")
    face = outlines.Typeface(data_of(made), "test")
    assert [face.kerning(*pair) for pair in ((1, 2), (2, 1), (1, 1), (0, 1))] == [-0.1, 0.04, 0.0, 0.0]


def refused(data: bytes, text: str = "AB") -> str:
    with pytest.raises(SceneError) as caught:
        areas(outlines.Typeface(data, "test.ttf"), text)
    assert caught.value.name == "file"
    return caught.value.message


def test_what_is_no_font() -> None:
    assert "no TrueType or OpenType font" in refused(b"hello")
    assert "no TrueType or OpenType font" in refused(b"wOF2" + bytes(100))
    assert refused(b"OTTO" + bytes(100)).endswith("it is damaged, or lacks what TrueType and OpenType fonts have")


def damaged(is_truetype: bool) -> TTFont:
    """A font that fontTools saves without looking at its glyphs."""
    return TTFont(io.BytesIO(DATA[is_truetype]), recalcBBoxes=False)


def saved(font: TTFont) -> bytes:
    out = io.BytesIO()
    font.save(out)
    return out.getvalue()


def test_components_that_contain_themselves_end() -> None:
    pen = TTGlyphPen({"A": None, "B": None})
    for x in (0, 9):
        pen.addComponent("B", (1, 0, 0, 1, x, 0))
    font, glyph = damaged(True), pen.glyph()
    glyph.xMin = glyph.yMin = glyph.xMax = glyph.yMax = 0
    font["glyf"].glyphs["A"] = glyph
    assert "nested too deeply" in refused(saved(font))


def test_programs_that_call_themselves_end() -> None:
    font = damaged(False)
    cff = font["CFF "].cff
    cff.GlobalSubrs.append(T2CharString(program=[-107, "callgsubr", -107, "callgsubr", "return"]))
    cff.topDictIndex[0].CharStrings["A"].setProgram([-107, "callgsubr", "endchar"])
    assert "program of the glyph" in refused(saved(font), "A")


@settings(max_examples=150, deadline=None)
@given(st.binary(min_size=1, max_size=12), st.floats(0.0, 1.0), st.booleans())
def test_damaged_fonts_are_errors_or_are_read(noise: bytes, share: float, is_truetype: bool) -> None:
    data = bytearray(DATA[is_truetype])
    place = int(share * (len(data) - len(noise)))
    data[place : place + len(noise)] = noise
    with suppress(SceneError):
        face = outlines.Typeface(bytes(data), "test")
        areas(face, "AB")
        face.kerning(1, 2)


DATA = {True: data_of(truetype()), False: data_of(postscript())}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "project").mkdir()
    (tmp_path / "project" / "a.ttf").write_bytes(DATA[True])
    (tmp_path / "outside.otf").write_bytes(DATA[False])
    return tmp_path / "project"


def runtime(folder: Path, allow_outside: bool = False) -> Runtime:
    return Runtime(build_library(), font=outlines.FontFiles(folder, folder, allow_outside).load)


def outline(rt: Runtime, file: str) -> list[Any]:
    entry = rt.library.builtins["text-outline"]
    return list(list_items(call_builtin(rt, entry, ["AB", Keyword("font"), file])))


def test_files_in_the_project(folder: Path) -> None:
    rt = runtime(folder)
    assert len(outline(rt, "a.ttf")) == 3
    assert rt.output == 1
    for file, name in (("b.ttf", "file"), ("../outside.otf", "import-outside"), ("a\0b", "file"), (".", "file")):
        with pytest.raises(SceneError) as caught:
            outline(rt, file)
        assert caught.value.name == name


def test_files_outside_must_be_allowed(folder: Path) -> None:
    assert len(outline(runtime(folder, True), "../outside.otf")) == 2


def test_large_files_are_errors(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(outlines, "MAX_FONT_BYTES", 100)
    with pytest.raises(SceneError, match="more than the limit"):
        outline(runtime(folder), "a.ttf")
