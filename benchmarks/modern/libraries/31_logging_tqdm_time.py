"""
a stack that logs its progress
"""
from helper import *
import logging
import sys
import time
import warnings
from tqdm import tqdm

logging.basicConfig(level=logging.INFO, format='%(asctime)s %(message)s')
log = logging.getLogger(__name__)
warnings.filterwarnings('ignore')


@register()
def stack(n: int = 6) -> Shape:
    start = time.perf_counter()
    shapes = []
    for i in tqdm(range(n), desc='stacking'):
        shapes.append(transform_shape(primitive_call('cube', color=(.5, .3, i / n), shape_kwargs={'scale': 1 - i / n / 2}), translation_matrix((0, i, 0))))
        log.debug('cube %d', i)
    elapsed = time.perf_counter() - start
    log.info('built %d cubes in %.2f s', len(shapes), elapsed)
    print(f'done in {elapsed:.3f} s', file=sys.stderr)
    return concat_shapes(*shapes)
