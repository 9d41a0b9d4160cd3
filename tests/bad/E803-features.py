class Base:
    height = 1


class Leg(Base):
    def build(self):
        wave = np.fft.fft([1, self.height])
        return primitive_call('cube', shape_kwargs={'scale': wave})


@register()
def scene() -> Shape:
    return Leg().build()
