"""Gaussian splatting: Gaussians of a scene, their rasterisers and files."""
