class Base:
    pass


class Leg(Base):
    height = 1


@register()
def scene() -> Shape:
    with lock:
        pass
    async_part = np.fft.fft([1, 2])
    return primitive_call('cube', shape_kwargs={'scale': np.array([1, 2]) > 1})
