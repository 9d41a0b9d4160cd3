"""What an entity graph contains, for people and programs that ask.

``numbering`` gives handles, ``instance_paths`` finds instances by words, ``outline`` prints the hierarchy,
``difference`` compares two graphs. Nothing here evaluates, or draws.
"""
