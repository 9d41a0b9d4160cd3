from __future__ import annotations
from enum import Enum, auto
from typing import Callable
from helper import *

"""
vending kiosks that show the state they reached
"""


class State(Enum):
    IDLE = auto()
    PAYING = auto()
    READY = auto()
    VENDING = auto()
    BROKEN = auto()


class Kiosk:
    PRICE = 3

    def __init__(self) -> None:
        self.state = State.IDLE
        self.credit = 0
        self.sold: list[str] = []
        self.history: list[State] = [self.state]

    def handle(self, event: str) -> None:
        method: Callable = getattr(self, f"on_{self.state.name.lower()}", self.ignore)
        following = method(event)
        if following is not None and following is not self.state:
            self.state = following
            self.history.append(following)

    def ignore(self, event):
        return None

    def on_idle(self, event):
        match event.split(":"):
            case ["coin", amount]:
                self.credit += int(amount)
                return State.READY if self.credit >= self.PRICE else State.PAYING
            case ["kick"]:
                return State.BROKEN

    on_paying = on_idle

    def on_ready(self, event):
        kind, _, item = event.partition(":")
        if kind == "choose":
            self.credit -= self.PRICE
            self.sold.append(item)
            return State.VENDING
        return self.on_idle(event)

    def on_vending(self, event):
        if event == "take":
            return State.IDLE if self.credit < self.PRICE else State.READY


SCRIPTS = [
    "coin:1 coin:2 choose:cola take",
    "coin:5 choose:tea take choose:milk",
    "choose:cola coin:1 kick coin:2",
    "coin:9 choose:tea take choose:tea take choose:cola take",
    "coin:1",
]
LIGHT = dict(zip(State, [(0.5, 0.5, 0.5), (0.9, 0.8, 0.2), (0.2, 0.8, 0.3), (0.2, 0.5, 0.9), (0.9, 0.1, 0.1)]))


@register()
def kiosk(machine: Kiosk) -> Shape:
    body = transform_shape(primitive_call('cube', color=(0.3, 0.3, 0.5), shape_kwargs={'scale': (1, 2, 0.8)}), translation_matrix((0, 1, 0)))
    lamps = loop(len(machine.history), lambda i: transform_shape(primitive_call('sphere', color=LIGHT[machine.history[i]], shape_kwargs={'radius': 0.1}), translation_matrix((0.25 * (i % 4) - 0.37, 2.2 + 0.25 * (i // 4), 0))))
    goods = [transform_shape(primitive_call('cube', color=(0.9, 0.3 * (len(name) - 3), 0.2), shape_kwargs={'scale': 0.2}), translation_matrix((-0.3 + 0.3 * k, 0.2, 0.6))) for k, name in enumerate(machine.sold)]
    coins = loop(machine.credit, lambda i: primitive_call('cylinder', color=(0.9, 0.8, 0.3), shape_kwargs={'radius': 0.08, 'p0': (0.7, 0.05 * i, 0.3), 'p1': (0.7, 0.05 * i + 0.04, 0.3)}))
    return concat_shapes(body, lamps, *goods, coins)


@register()
def arcade() -> Shape:
    shapes = []
    for k, script in enumerate(SCRIPTS):
        machine = Kiosk()
        for event in script.split():
            machine.handle(event)
        shapes.append(transform_shape(library_call('kiosk', machine=machine), translation_matrix((1.8 * k, 0, 0))))
    return concat_shapes(*shapes)
