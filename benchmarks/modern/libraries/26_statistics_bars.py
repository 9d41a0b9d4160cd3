"""
bars with their mean and deviation
"""
from helper import *
import statistics
from statistics import mean, median, stdev, quantiles

SAMPLES = {'a': [2, 4, 4, 5, 7], 'b': [1, 1, 2, 9, 9], 'c': [3, 3.5, 4, 4.5, 5]}


@register()
def box_plot(values, width: float = .6) -> Shape:
    q1, q2, q3 = quantiles(values, n=4)
    body = transform_shape(primitive_call('cube', color=(.4, .6, .8), shape_kwargs={'scale': (width, q3 - q1, width)}), translation_matrix((0, (q1 + q3) / 2, 0)))
    line = transform_shape(primitive_call('cube', color=(0, 0, 0), shape_kwargs={'scale': (width * 1.1, .05, width * 1.1)}), translation_matrix((0, median(values), 0)))
    whisker = primitive_call('cylinder', color=(.2, .2, .2), shape_kwargs={'radius': .04, 'p0': (0, min(values), 0), 'p1': (0, max(values), 0)})
    dot = transform_shape(primitive_call('sphere', color=(1, 0, 0), shape_kwargs={'radius': .05 * stdev(values)}), translation_matrix((0, mean(values), width)))
    return concat_shapes(body, line, whisker, dot)


@register()
def chart() -> Shape:
    return concat_shapes(*[transform_shape(library_call('box_plot', values=v), translation_matrix((i * 1.5, statistics.pvariance(v) * .01, 0))) for i, v in enumerate(SAMPLES.values())])
