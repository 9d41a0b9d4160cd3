"""Draft pictures: the ray caster with light, in numpy alone."""
