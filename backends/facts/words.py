"""Words that soften a finding into a note, by the head of a phrase: the only nouns that any check knows.

A word never makes a finding, and never hides one. Programs say exactly what they mean by ``:floating``, ``:fixed`` and
declarations.
"""

from __future__ import annotations


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


# What flies or hangs in the sky, in English, German, French and Spanish.
FLYING = _words(
    """
    airplane airship angel asteroid balloon bat bee bird bubble butterfly cloud comet crow dragonfly drone eagle fairy
    feather firefly fly galaxy ghost gull halo helicopter jet kite meteor mist moon planet plane raindrop rainbow
    rocket satellite seagull smoke snowflake spaceship spark sparrow star sun swallow ufo
    adler ballon biene blase drachen fee flocke flugzeug hubschrauber komet libelle mond moewe möwe nebel planet
    rakete rauch regenbogen regentropfen satellit schmetterling schneeflocke schwalbe sonne stern vogel wolke
    abeille avion étoile fusée lune nuage oiseau papillon soleil
    avión cometa estrella globo luna mariposa nube pájaro pajaro sol
    """
)
# What gives way, flows or grows, so that others may be in it.
SOFT = _words(
    """
    blanket bush canopy carpet cloth cloud crown curtain cushion flame fog foliage fur grass hair hay hedge ivy lawn
    leaf leaves mattress moss mud pillow plant quilt rug sand scarf shrub smoke snow soil towel water wool
    blatt busch decke erde gebüsch gras hecke heu kissen krone laub matratze moos nebel pflanze polster rasen
    rauch sand schal schnee stroh teppich tuch vorhang wasser wiese wolke
    """
)


def head_of(phrase: str) -> str:
    """Return the singular of the last noun of a phrase, lower case.

    Examples
    --------
    >>> head_of("snow-flakes"), head_of("floor lamp 2")
    ('flake', 'lamp')
    """
    noun = phrase.lower().replace("_", "-").replace(" ", "-").rstrip("-0123456789").split("-")[-1]
    return noun[:-1] if noun.endswith("s") and not noun.endswith("ss") and len(noun) > 3 else noun


def flies(phrase: str) -> bool:
    """Return whether the last noun of a phrase is one of things that fly or hang in the sky.

    Examples
    --------
    >>> flies("paper planes"), flies("plane table")
    (True, False)
    """
    return _is_among(phrase, FLYING)


def is_soft(phrase: str) -> bool:
    """Return whether the head of a phrase names what gives way, flows or grows."""
    return _is_among(phrase, SOFT)


def _is_among(phrase: str, words: frozenset[str]) -> bool:
    """Return whether the head of a phrase is among words, in the plural or as the end of a compound too."""
    head = head_of(phrase)
    forms = {head, head.removesuffix("n"), head.removesuffix("en"), head.removesuffix("e")}
    return bool(forms & words) or any(len(word) > 4 and form.endswith(word) for form in forms for word in words)
