class Base:
    height = 1


class Leg(Base):
    def build(self):
        wave = [1 + self.height, 2, 1]
        return primitive_call('cube', shape_kwargs={'scale': wave})


@register()
def scene() -> Shape:
    return Leg().build()
