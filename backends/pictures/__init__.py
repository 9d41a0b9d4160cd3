"""Pictures and films: cameras, light, the ray caster, draft and final quality."""
