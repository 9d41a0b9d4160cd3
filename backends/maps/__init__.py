"""Maps: what every pixel of a picture shows, exactly."""
