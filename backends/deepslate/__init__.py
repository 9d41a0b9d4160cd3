"""Pictures of Minecraft builds with the game's own looks, drawn by deepslate in a browser.

``looks`` reads models and textures of the game, ``builds`` and ``layers`` say what is seen, ``backend`` drives the
page. Where the game's files are not there, blocks have their average colour. It does not know how a build was made.
"""
