"""Final pictures: path tracing with Mitsuba 3."""
