"""Tables of the parsers, and the program that makes them."""
