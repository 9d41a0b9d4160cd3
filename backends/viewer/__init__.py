"""The live viewer: a scene as a compact packet, and the page that shows it."""
