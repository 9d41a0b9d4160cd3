"""Block states as files name them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from scenelang.backends.minecraft.asked import NAMESPACE
from scenelang.backends.minecraft.blocks import AIR_STATE, NOTHING, BlockState
from scenelang.backends.minecraft.files.damage import Damaged

_NAME = re.compile(r"(?:[a-z0-9_.-]+:)?[a-z0-9_./-]+")
_WORD = re.compile(r"[a-z0-9_]+")
_LONGEST = 200  # letters of a name
_MOST = 64  # properties of one block


def state_of_text(text: str) -> BlockState:
    """The state that is written ``minecraft:oak_log[axis=x]``; raises Damaged."""
    name, bracket, rest = text.partition("[")
    if bracket and not rest.endswith("]"):
        raise Damaged(f"`{text[:60]}` is no block")
    pairs = [pair.partition("=") for pair in rest[:-1].split(",") if pair]
    return _state(name, {key: value for key, _, value in pairs})


def state_of_tag(tag: Any) -> BlockState:
    """The state of a compound with ``Name`` and ``Properties``; raises Damaged."""
    name = tag.get("Name") if isinstance(tag, dict) else None
    properties = tag.get("Properties", {}) if isinstance(tag, dict) else None
    if not isinstance(name, str) or not isinstance(properties, dict):
        raise Damaged("an entry of its palette is no block")
    return _state(name, properties)


def tag_of_state(state: BlockState) -> dict[str, Any]:
    """The compound that ``state_of_tag`` reads."""
    tag: dict[str, Any] = {"Name": state.name}
    return {**tag, "Properties": dict(state.properties)} if state.properties else tag


def _state(name: str, properties: Mapping[str, Any]) -> BlockState:
    if len(name) > _LONGEST or not _NAME.fullmatch(name):
        raise Damaged(f"`{name[:60]}` is no name of a block")
    if len(properties) > _MOST:
        raise Damaged(f"`{name}` has {len(properties)} properties")
    for pair in properties.items():
        if not all(isinstance(word, str) and len(word) <= _LONGEST and _WORD.fullmatch(word) for word in pair):
            raise Damaged(f"`{name}` has a property that is none")
    full = name if ":" in name else NAMESPACE + name
    if full in NOTHING:
        return AIR_STATE
    return BlockState(full, tuple(sorted(properties.items())))
