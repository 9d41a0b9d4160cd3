"""Per-pixel ground truth (docs/labels.md).

``ground_truth`` computes instances, depth, normals, boxes and motion of a shot; ``dataset`` writes them, including COCO
annotations. Color images come from the image backends.
"""
