"""The entity graph and its geometry: poses, bounds, flattening, numbering, comparison."""
