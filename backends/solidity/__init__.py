"""How solids stand to one another: distance, depth, contact; and what is probably wrong with a scene's geometry."""
