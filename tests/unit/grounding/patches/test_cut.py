from collections.abc import Iterator, Sequence

import cv2
import numpy as np

from grounding.patches.cut import PatchConfig, Showing, cut_patches
from grounding.patches.patch import PATCH_COLUMNS, Rejection
from grounding.patches.view import TimedImage

SCALE_PX = 500.0


class FlatCamera:
    """Looks straight down: 500 px a metre, the world's origin in the middle of 400 x 400."""

    def project(self, points_world: np.ndarray) -> np.ndarray:
        return points_world[:, :2] * [SCALE_PX, -SCALE_PX] + 199.5


class TableView:
    """A red square at the origin; a grey arm lies over it at some times."""

    name = "overhead"
    is_fixed = True

    def __init__(self, *, arm_ns: Sequence[int] = ()) -> None:
        self.t_ns = [int(k * 1e8) for k in range(40)]
        self._arm_ns = set(arm_ns)

    def camera_at(self, _t_ns: int) -> FlatCamera:
        return FlatCamera()

    def images(self, times_ns: Sequence[int]) -> Iterator[TimedImage]:
        for t_ns in times_ns:
            image = np.full((400, 400, 3), (110, 140, 170), np.uint8)
            cv2.rectangle(image, (190, 190), (210, 210), (30, 30, 200), -1)
            if t_ns in self._arm_ns:
                cv2.rectangle(image, (195, 0), (220, 400), (150, 160, 190), -1)
            yield TimedImage(t_ns=t_ns, image_bgr=image)


def showing(*, at: tuple[float, float] = (0.0, 0.0), looked_at: bool = True) -> Showing:
    return Showing(
        instruction=3,
        symbols=("red", "cube"),
        weight=0.9,
        object_id="object-1",
        position_world=np.array([*at, 0.02]),
        quat_xyzw=np.array([0.0, 0.0, 0.0, 1.0]),
        size_m=np.full(3, 0.04),
        since_ns=0,
        until_ns=int(3.9e9),
        is_looked_at=looked_at,
    )


def rejections(view: TableView, *showings: Showing) -> list[Rejection | None]:
    return [patch.rejection for patch in cut_patches(showings, view, PatchConfig())]


def test_a_thing_that_stands_free_gives_patches_around_its_middle() -> None:
    patches = cut_patches([showing()], TableView(), PatchConfig())
    assert [patch.kept for patch in patches] == [True] * 6
    assert np.allclose(patches[0].uv_px, 199.5)
    assert patches[0].mm_per_px is not None
    assert abs(patches[0].mm_per_px - 2.0) < 1e-6


def test_a_patch_with_an_arm_before_the_thing_is_refused() -> None:
    view = TableView(arm_ns=[int(k * 1e8) for k in range(12)])
    patches = cut_patches([showing()], view, PatchConfig())
    covered = {p.t_ns for p in patches if p.rejection is Rejection.COVERED}
    assert covered
    assert max(covered) < int(1.2e9) <= min(p.t_ns for p in patches if p.kept)


def test_a_thing_at_the_edge_is_cut_off() -> None:
    assert set(rejections(TableView(), showing(at=(0.39, 0.0)))) == {Rejection.CUT_OFF}


def test_a_bare_table_is_background() -> None:
    assert set(rejections(TableView(), showing(at=(0.2, 0.2)))) == {Rejection.BACKGROUND}


def test_a_thing_that_nobody_looked_at_is_refused() -> None:
    assert set(rejections(TableView(), showing(looked_at=False))) == {Rejection.GATE}


def test_a_row_has_the_columns_of_the_interface() -> None:
    row = cut_patches([showing()], TableView(), PatchConfig())[0].row()
    assert tuple(row) == PATCH_COLUMNS
    assert (row["symbols"], row["kept"], row["reason"]) == ("red cube", 1, "")
