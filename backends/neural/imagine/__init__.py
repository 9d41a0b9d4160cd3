"""Pictures by text-to-image models that follow a scene's layout."""
