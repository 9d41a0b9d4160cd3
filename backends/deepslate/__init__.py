"""Pictures of Minecraft builds with the game's models and textures, rendered by deepslate in a browser.

``looks`` reads models and textures of the game, ``builds`` and ``layers`` select the visible blocks and resource packs,
``backend`` controls the page. Without the game's files, blocks have their average color. This package is independent
of how a build was made.
"""
