"""Pictures and a page of builds with the game's own looks, drawn by deepslate in a browser."""
