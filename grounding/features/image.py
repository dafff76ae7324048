"""Read a patch from a file that may be anything."""

import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from PIL import Image, UnidentifiedImageError

from grounding.errors import InputError
from grounding.features.background import Mask
from grounding.types import ImageArray

MAX_SIDE_PX: Final = 8192
_DEEP: Final = ("I;16", "I;16B", "I;16L", "I", "F")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PatchImage:
    """An image as features want it.

    Attributes:
        bgr: (H, W, 3).
        mask: (H, W) from an alpha channel that cuts something out, else None.
        note: what had to be done to it, in a few words; empty for a plain colour image.
    """

    bgr: ImageArray
    mask: Mask | None
    note: str = ""


def read_patch(path: Path) -> PatchImage:
    """Read an image file: 8 or 16 bit, grey or colour, with or without alpha.

    Raises:
        InputError: if there is no such file, it is no whole image, or far too large for a patch.
    """
    if path.exists() and not (path.is_file() or path.is_dir()):
        raise InputError("no file, a pipe or a device", where=path, todo="give a PNG or JPEG")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            with Image.open(path) as image:
                if max(image.size) > MAX_SIDE_PX:
                    width, height = image.size
                    raise InputError(
                        f"{width} x {height} pixels, at most {MAX_SIDE_PX} a side",
                        where=path,
                        todo="cut the patch out of the image",
                    )
                return _as_patch(image)
    except IsADirectoryError as error:
        raise InputError("a folder, no image", where=path, todo="give its images") from error
    except FileNotFoundError as error:
        raise InputError("no such file", where=path, todo="check the path") from error
    except UnidentifiedImageError as error:
        raise InputError("not an image", where=path, todo="give a PNG or JPEG") from error
    except (OSError, ValueError, SyntaxError, Warning, Image.DecompressionBombError) as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise InputError(
            f"the image is damaged ({reason})", where=path, todo="write it again"
        ) from error


def _as_patch(image: Image.Image) -> PatchImage:
    """Return the decoded image as BGR."""
    note = "" if image.mode == "RGB" else f"read as colour from {image.mode}"
    if image.mode in _DEEP:
        deep = np.asarray(image, dtype=np.float64)
        top = 65535.0 if image.mode.startswith("I") else max(1.0, float(np.nanmax(deep)))
        grey = np.clip(np.nan_to_num(deep) * (255 / top), 0, 255).astype(np.uint8)
        return PatchImage(bgr=np.repeat(grey[..., None], 3, axis=2), mask=None, note=note)
    has_alpha = "A" in image.getbands() or "transparency" in image.info
    pixels = np.asarray(image.convert("RGBA" if has_alpha else "RGB"))
    mask = pixels[..., 3] > 127 if has_alpha else None
    if mask is not None and (mask.all() or not mask.any()):
        mask = None
    return PatchImage(bgr=np.ascontiguousarray(pixels[..., 2::-1]), mask=mask, note=note)
