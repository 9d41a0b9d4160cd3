"""Ground truth for every pixel: instances, depth, normals, boxes, motion, and datasets of them."""
