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
    arm_bgr = (150, 160, 190)

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
                cv2.rectangle(image, (195, 0), (220, 400), self.arm_bgr, -1)
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


class WalkingView(TableView):
    """The same table from a camera that shifts from picture to picture, with a cube's side seen."""

    name = "head"
    is_fixed = False
    arm_bgr = (60, 60, 60)

    def camera_at(self, t_ns: int) -> FlatCamera:
        return ShiftedCamera(shift_px=self._shift_px(t_ns))

    def images(self, times_ns: Sequence[int]) -> Iterator[TimedImage]:
        for timed in super().images(times_ns):
            turn = np.array([[1.0, 0.0, self._shift_px(timed.t_ns)], [0.0, 1.0, 0.0]])
            moved = cv2.warpAffine(
                timed.image_bgr, turn, (400, 400), borderMode=cv2.BORDER_REPLICATE
            )
            yield TimedImage(t_ns=timed.t_ns, image_bgr=np.asarray(moved, np.uint8))

    @staticmethod
    def _shift_px(t_ns: int) -> float:
        return 60.0 * np.sin(t_ns / 1e9)


class ShiftedCamera(FlatCamera):
    def __init__(self, *, shift_px: float) -> None:
        self._shift_px = shift_px

    def project(self, points_world: np.ndarray) -> np.ndarray:
        return super().project(points_world) + np.array([self._shift_px, 0.0])


def test_a_moving_camera_gives_patches_as_from_above() -> None:
    patches = cut_patches([showing()], WalkingView(), PatchConfig())
    assert [patch.kept for patch in patches] == [True] * 6
    first = patches[0].image_bgr
    for patch in patches:
        assert patch.camera == "head"
        assert abs(patch.uv_px[0] - 199.5 - WalkingView._shift_px(patch.t_ns)) < 1e-6
        assert patch.image_bgr is not None
        assert first is not None
        assert np.mean(np.abs(patch.image_bgr.astype(int) - first)) < 3.0


def test_a_hand_before_a_moving_camera_is_refused() -> None:
    view = WalkingView(arm_ns=[int(k * 1e8) for k in range(12)])
    patches = cut_patches([showing()], view, PatchConfig())
    assert {p.t_ns < int(1.2e9) for p in patches if p.rejection is Rejection.COVERED} == {True}
    assert len([p for p in patches if p.kept]) == 6


def test_a_row_has_the_columns_of_the_interface() -> None:
    row = cut_patches([showing()], TableView(), PatchConfig())[0].row()
    assert tuple(row) == PATCH_COLUMNS
    assert (row["symbols"], row["kept"], row["reason"]) == ("red cube", 1, "")
