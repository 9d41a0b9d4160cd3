"""Everything that runs a neural model: CLIP, diffusion, splats, distillation, inversion, metrics."""
