from helper import *

"""
three thermometers showing the same weather in different units
"""

def clamp(value: float, low: float, high: float) -> float:
    return low if value < low else high if value > high else value

class Temperature:
    """Stores celsius; the other scales are views of it."""

    def __init__(self, celsius: float = 0.0) -> None:
        self.celsius = celsius

    @property
    def fahrenheit(self) -> float:
        return self.celsius * 9 / 5 + 32

    @fahrenheit.setter
    def fahrenheit(self, value: float) -> None:
        self.celsius = (value - 32) * 5 / 9

    @property
    def kelvin(self) -> float:
        return self.celsius + 273.15

    @kelvin.setter
    def kelvin(self, value: float) -> None:
        if value < 0:
            raise ValueError("below absolute zero")
        self.celsius = value - 273.15

    @property
    def color(self) -> Tuple[float, float, float]:
        t = clamp((self.celsius + 10) / 50, 0, 1)
        return (t, 0.2, 1 - t)

class Thermometer:
    def __init__(self, scale: str, low: float, high: float):
        self.scale, self.low, self.high = scale, low, high

    def fraction(self, temperature: Temperature) -> float:
        return clamp((getattr(temperature, self.scale) - self.low) / (self.high - self.low), 0, 1)

@register()
def thermometer(scale: str, low: float, high: float, temperature: Temperature) -> Shape:
    meter = Thermometer(scale, low, high)
    level = 2 * meter.fraction(temperature)
    bulb = primitive_call('sphere', color=temperature.color, shape_kwargs={'radius': 0.25})
    liquid = primitive_call('cylinder', color=temperature.color, shape_kwargs={'radius': 0.08, 'p0': (0, 0, 0), 'p1': (0, 0.25 + level, 0)})
    board = transform_shape(primitive_call('cube', color=(0.9, 0.85, 0.7), shape_kwargs={'scale': (0.8, 3, 0.05)}), translation_matrix((0, 1.1, -0.2)))
    ticks = loop(11, lambda i: transform_shape(
        primitive_call('cube', color=(0, 0, 0), shape_kwargs={'scale': (0.3 if i % 5 == 0 else 0.15, 0.02, 0.02)}), translation_matrix((0.25, 0.25 + 0.2 * i, -0.15))))
    return concat_shapes(board, bulb, liquid, ticks)

@register()
def weather_station() -> Shape:
    weather = Temperature()
    weather.fahrenheit = 86
    weather.celsius -= 4.5
    weather.kelvin += 1.5
    failures = 0
    for bad in (-1, -300, 300):
        try:
            Temperature().kelvin = bad
        except ValueError:
            failures += 1
    meters = [("celsius", -20, 50), ("fahrenheit", 0, 120), ("kelvin", 250, 320)]
    row = [transform_shape(library_call('thermometer', scale=s, low=lo, high=hi, temperature=weather), translation_matrix((1.2 * k, 0, 0))) for k, (s, lo, hi) in enumerate(meters)]
    lamps = loop(failures, lambda i: transform_shape(primitive_call('sphere', color=(1, 0, 0), shape_kwargs={'radius': 0.1}), translation_matrix((1 + 0.3 * i, 3, 0))))
    return concat_shapes(*row, lamps)
