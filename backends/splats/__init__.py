"""Scenes as 3D Gaussians: their poses, a differentiable rasteriser, and files of them. Everything here needs torch."""
