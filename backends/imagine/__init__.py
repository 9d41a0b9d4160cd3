"""Pictures by a text-to-image model that is told what stands where: the paper's renderer of layouts (section 4)."""
