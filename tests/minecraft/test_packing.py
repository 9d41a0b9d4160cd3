"""Numbers as bytes, against loops over their bits."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenelang.backends.minecraft.nbt import Damaged, from_packed_longs, from_varints, packed_longs, varints

NUMBERS = st.lists(st.one_of(st.integers(0, 300), st.integers(0, 2**32 - 1)), max_size=300)


def slow_varints(numbers: list[int]) -> bytes:
    out = bytearray()
    for number in numbers:
        while number >= 0x80:
            out.append(number & 0x7F | 0x80)
            number >>= 7
        out.append(number)
    return bytes(out)


def slow_longs(numbers: list[int], bits: int) -> list[int]:
    whole = sum(number << (i * bits) for i, number in enumerate(numbers))
    return [whole >> (64 * i) & (2**64 - 1) for i in range(-(-len(numbers) * bits // 64))]


@given(NUMBERS)
def test_varints(numbers: list[int]) -> None:
    packed = varints(np.array(numbers, np.uint32))
    assert packed.tobytes() == slow_varints(numbers)
    assert from_varints(packed, len(numbers)).tolist() == numbers


def test_varints_of_many_numbers() -> None:
    numbers = np.random.default_rng(1).integers(0, 40_000, 2_500_000).astype(np.uint32)
    packed = varints(numbers)
    assert packed[:1000].tobytes() == slow_varints(numbers.tolist()[:1000])[:1000]
    assert (from_varints(packed, len(numbers)) == numbers).all()


@given(NUMBERS, st.integers(2, 32))
def test_longs(numbers: list[int], bits: int) -> None:
    numbers = [number % (1 << bits) for number in numbers]
    packed = packed_longs(np.array(numbers, np.uint32), bits)
    assert packed.tolist() == slow_longs(numbers, bits)
    assert from_packed_longs(packed, len(numbers), bits).tolist() == numbers


@pytest.mark.parametrize("data", [b"\x80", b"\x01\x80", b"\x01", b"\x01\x02\x03", b"\x80" * 6 + b"\x01\x01"])
def test_damaged_varints(data: bytes) -> None:
    with pytest.raises(Damaged):
        from_varints(np.frombuffer(data, np.uint8), 2)


def test_too_few_longs() -> None:
    with pytest.raises(Damaged):
        from_packed_longs(np.zeros(3, np.uint64), 65, 3)
