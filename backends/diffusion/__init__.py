"""Diffusion models that judge pictures: of one picture with a depth map, or of several views of a thing at once."""
