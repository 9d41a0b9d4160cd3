"""How well pictures fit texts and other pictures, how much moves in a film, how many things a scene has."""
