import random
from dataclasses import dataclass


class Part:
    def build(self):
        return primitive_call('cube')


class Ball(Part):
    def build(self):
        return primitive_call('sphere')


@register()
def scene() -> Shape:
    kind = Ball if random.random() < 0.5 else Part
    return kind().build()
