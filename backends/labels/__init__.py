"""Ground truth for every pixel (docs/maps.md).

``ground_truth`` works out instances, depth, normals, boxes and motion of a shot, ``dataset`` writes them, as COCO too.
It draws nothing: colours come from the backends of pictures.
"""
