"""A patch: a picture of an instruction's target, and what is to be learnt from it."""

from dataclasses import dataclass
from enum import StrEnum

from grounding.types import FloatArray, ImageArray

PATCH_COLUMNS = (
    "patch",
    "camera",
    "t_ns",
    "u [px]",
    "v [px]",
    "instruction",
    "symbols",
    "weight",
    "kept",
    "reason",
    "mm_per_px",
    "height_mm",
    "object",
)


class Rejection(StrEnum):
    """Why a patch is not learnt from."""

    CUT_OFF = "cut off by the image's edge"
    COVERED = "a hand or another thing is before it"
    BLURRED = "blurred"
    BACKGROUND = "background only"
    GATE = "no look within three sigma of the target"
    DOUBTFUL = "the target is not certain"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Patch:
    """A crop around the target of an instruction.

    Attributes:
        name: of its file in `patches/`.
        camera: `overhead` or `head`.
        t_ns: the image's time.
        uv_px: (2,) the patch's centre in the image.
        instruction: index of the instruction.
        symbols: the target's words.
        weight: posterior that the words belong to what the patch shows.
        image_bgr: (H, W, 3), or None where nothing could be cut.
        mm_per_px: metric scale in the plane of the thing's top, or None.
        height_mm: the thing's height, or None.
        object_id: the instance it shows, or None.
        rejection: why it is not kept, or None.
    """

    name: str
    camera: str
    t_ns: int
    uv_px: FloatArray
    instruction: int
    symbols: tuple[str, ...]
    weight: float
    image_bgr: ImageArray | None
    mm_per_px: float | None
    height_mm: float | None
    object_id: str | None
    rejection: Rejection | None

    @property
    def kept(self) -> bool:
        """Whether it is learnt from."""
        return self.rejection is None

    def row(self) -> dict[str, object]:
        """Return its row of patches.csv, keyed by `PATCH_COLUMNS`."""
        scale, height = self.mm_per_px, self.height_mm
        values = (
            self.name if self.image_bgr is not None else "",
            self.camera,
            self.t_ns,
            f"{self.uv_px[0]:.2f}",
            f"{self.uv_px[1]:.2f}",
            self.instruction,
            " ".join(self.symbols),
            f"{self.weight:.4f}",
            int(self.kept),
            "" if self.rejection is None else str(self.rejection),
            "" if scale is None else f"{scale:.4f}",
            "" if height is None else f"{height:.1f}",
            self.object_id or "",
        )
        return dict(zip(PATCH_COLUMNS, values, strict=True))
