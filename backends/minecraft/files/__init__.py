"""Files of builds that the game and its tools read and write."""
