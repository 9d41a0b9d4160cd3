"""Pictures of users, as models take them."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path

from scenelang.backends.files import read_regular
from scenelang.backends.language_models.conversation import Picture
from scenelang.grammar.diagnostics import SceneError

ENDINGS = {"image/png": "png", "image/jpeg": "jpg", "image/webp": "webp", "image/gif": "gif"}  # what models take
_LARGEST_SIDE = 1568  # pixels; services make larger ones smaller
_LARGEST_FILE = 3_500_000  # bytes, before they are written in base 64
_MOST_BYTES = 100_000_000
_ORIENTATION = 0x0112  # in EXIF: how a camera was held


def read_picture(path: str) -> Picture:
    """A picture file as models take it: as it is where its format and size allow, else upright, smaller, on white
    and as JPEG. Raises SceneError for a file that is none."""
    from PIL import Image, ImageOps, UnidentifiedImageError

    try:
        if Path(path).stat().st_size > _MOST_BYTES:
            raise SceneError("file", f"the picture {path} is larger than {_MOST_BYTES:,} bytes")
        data = read_regular(path)
        with Image.open(BytesIO(data)) as image:
            image.load()
            media_type = Image.MIME.get(image.format or "", "")
            is_upright = image.getexif().get(_ORIENTATION, 1) == 1
            fits = is_upright and max(image.size) <= _LARGEST_SIDE and len(data) <= _LARGEST_FILE
            if fits and media_type in ENDINGS:
                return Picture(media_type, data)
            upright = ImageOps.exif_transpose(image).convert("RGBA")
    except (OSError, ValueError, UnidentifiedImageError, Image.DecompressionBombError, SyntaxError) as error:
        reason = getattr(error, "strerror", None) or "it is no picture"
        raise SceneError("file", f"cannot read the picture {path}: {reason}") from None
    upright.thumbnail((_LARGEST_SIDE, _LARGEST_SIDE))
    flat = Image.new("RGBA", upright.size, "white")
    flat.alpha_composite(upright)
    buffer = BytesIO()
    flat.convert("RGB").save(buffer, "JPEG", quality=90)
    return Picture("image/jpeg", buffer.getvalue())
