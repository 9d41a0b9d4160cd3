"""
a robot of a json configuration
"""
from helper import *
import json

CONFIG = json.loads('''
{"body": {"size": [1, 1.5, 0.6], "color": [0.6, 0.6, 0.7]},
 "limbs": [{"at": [0.7, 0.2, 0], "length": 1.2}, {"at": [-0.7, 0.2, 0], "length": 1.2},
           {"at": [0.3, -1.2, 0], "length": 0.9}, {"at": [-0.3, -1.2, 0], "length": 0.9}],
 "head": {"radius": 0.4, "eyes": true}}
''')


@register()
def limb(length: float) -> Shape:
    return primitive_call('cube', color=(.3, .3, .35), shape_kwargs={'scale': (.25, length, .25)})


@register()
def robot() -> Shape:
    body = primitive_call('cube', color=tuple(CONFIG['body']['color']), shape_kwargs={'scale': CONFIG['body']['size']})
    limbs = [transform_shape(library_call('limb', length=each['length']), translation_matrix(each['at'])) for each in CONFIG['limbs']]
    head = transform_shape(primitive_call('sphere', color=(.8, .8, .8), shape_kwargs={'radius': CONFIG['head']['radius']}), translation_matrix((0, 1.15, 0)))
    eyes = [transform_shape(primitive_call('sphere', color=(0, 0, 0), shape_kwargs={'radius': .08}), translation_matrix((x, 1.2, .36))) for x in (-.15, .15)] if CONFIG['head'].get('eyes') else []
    return concat_shapes(body, *limbs, head, *eyes)
