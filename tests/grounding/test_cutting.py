"""Parts cut out along known masks, pixel by pixel."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from scenelang.backends.neural.grounding import crop_masked, mask_box, random_grey, read_mask, resize
from scenelang.grammar.diagnostics import SceneError


def numbered(height: int, width: int) -> np.ndarray:
    """A picture whose every pixel is another."""
    count = np.arange(height * width).reshape(height, width)
    return np.stack([count % 256, count // 256, np.full_like(count, 7)], -1).astype(np.uint8)


def test_the_part_is_in_the_middle_of_a_square_on_grey() -> None:
    picture, mask = numbered(20, 30), np.zeros((20, 30), np.bool_)
    mask[4:6, 10:17] = True  # 7 wide, 2 high
    mask[4, 12] = False  # a hole
    square = crop_masked(picture, mask, 99)
    wanted = np.full((7, 7, 3), 99, np.uint8)
    for row in range(2):  # 5 rows are left over: 2 above, 3 below
        for column in range(7):
            if mask[4 + row, 10 + column]:
                wanted[2 + row, column] = picture[4 + row, 10 + column]
    assert np.array_equal(square, wanted)
    assert (square[2, 2] == 99).all()


def test_high_parts_are_padded_at_the_sides() -> None:
    picture, mask = numbered(9, 9), np.zeros((9, 9), np.bool_)
    mask[0:4, 8] = True  # at the edge of the picture
    square = crop_masked(picture, mask, 0)
    assert square.shape == (4, 4, 3)
    assert np.array_equal(square[:, 1], picture[0:4, 8])
    assert not square[:, [0, 2, 3]].any()


def test_the_whole_of_a_square_picture_is_itself() -> None:
    picture = numbered(12, 12)
    assert np.array_equal(crop_masked(picture, np.ones((12, 12), np.bool_), 5), picture)


def test_the_box_of_a_mask() -> None:
    mask = np.zeros((8, 9), np.bool_)
    mask[2, 3] = mask[5, 7] = True
    assert mask_box(mask) == (3, 2, 8, 6)
    with pytest.raises(SceneError, match="the mask is empty"):
        mask_box(np.zeros((3, 3), np.bool_))


def test_the_grey_depends_on_the_seed() -> None:
    greys = [random_grey(seed) for seed in range(200)]
    assert greys == [random_grey(seed) for seed in range(200)]
    assert len(set(greys)) > 60
    assert min(greys) < 20 < 235 < max(greys)


def test_the_size() -> None:
    flat = np.full((10, 10, 3), 77, np.uint8)
    assert np.array_equal(resize(flat, 32), np.full((32, 32, 3), 77, np.uint8))
    assert np.array_equal(resize(numbered(12, 12), 12), numbered(12, 12))


def test_masks_of_files(tmp_path: Path) -> None:
    known = np.zeros((6, 8), np.uint8)
    known[1:3, 2:5] = 255
    known[4, 4], known[5, 5] = 127, 128
    Image.fromarray(known).save(tmp_path / "mask.png")
    mask = read_mask(tmp_path / "mask.png", 8, 6)
    assert np.array_equal(mask, known >= 128)
    with pytest.raises(SceneError, match=r"the image's size 9 x 6, .* has 8 x 6"):
        read_mask(tmp_path / "mask.png", 9, 6)
    with pytest.raises(SceneError, match=r"as an image: No such file"):
        read_mask(tmp_path / "none.png", 9, 6)
