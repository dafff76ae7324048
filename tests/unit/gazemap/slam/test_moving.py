"""What moves by itself is masked; what moves with the map, skin-coloured or not, is not."""

import numpy as np
import pytest

from gazemap.geometry.pose import Pose
from gazemap.slam.moving import NO_VOTES, Followed, MovingMask, Votes, coarse_chroma, votes_of
from tests.planes import CAMERA

SKIN_BGR, TABLE_BGR, GREEN_BGR = (118, 148, 204), (60, 60, 60), (40, 160, 40)
WIDTH, HEIGHT = 480, 360


@pytest.fixture
def scene():
    """Return corners at random depths as two cameras saw them, and how the camera moved."""
    rng = np.random.default_rng(3)
    before_px = rng.uniform([20, 20], [380, 280], (120, 2))
    depth = rng.uniform(0.6, 1.0, 120)
    T_after_before = Pose.from_rotvec([0.01, -0.02, 0.005], [0.02, 0.005, -0.01])
    points = CAMERA.unproject(before_px)
    points *= (depth / points[:, 2])[:, None]
    return before_px, CAMERA.project(T_after_before.transform(points)), depth, T_after_before


def as_pixels(rows):
    return {tuple(np.round(row, 6)) for row in rows}


def test_corners_that_move_with_the_map_vote_for_it_whether_their_depth_is_known_or_not(scene):
    before_px, after_px, depth, T = scene
    depth = np.where(np.arange(120) % 2 == 0, depth, np.nan)
    followed = Followed(before_px=before_px, after_px=after_px, depth=depth)
    votes = votes_of(followed, CAMERA, T_after_before=T)
    assert len(votes.static_px) == 120
    assert len(votes.moving_px) == 0


def test_corners_that_no_depth_explains_vote_against_the_map(scene):
    before_px, after_px, depth, T = scene
    after_px = after_px.copy()
    after_px[:20, 1] += 4.0
    depth = np.where(np.arange(120) < 60, np.nan, depth)
    followed = Followed(before_px=before_px, after_px=after_px, depth=depth)
    votes = votes_of(followed, CAMERA, T_after_before=T)
    assert as_pixels(votes.moving_px) == as_pixels(after_px[:20])


def test_without_known_depths_nothing_is_judged(scene):
    before_px, after_px, _, T = scene
    followed = Followed(before_px=before_px, after_px=after_px, depth=np.full(120, np.nan))
    assert votes_of(followed, CAMERA, T_after_before=T) is NO_VOTES


def grid_px(low, high, step=20):
    u, v = np.meshgrid(*(np.arange(a, b, step) for a, b in zip(low, high, strict=True)))
    return np.column_stack([u.ravel(), v.ravel()]).astype(np.float64)


def everywhere_but(low, high):
    px = grid_px((10, 10), (WIDTH, HEIGHT))
    inside = ((px >= low) & (px < high)).all(axis=1)
    return px[~inside]


def masked(votes, image, frames=12):
    mask = MovingMask(width_px=WIDTH, height_px=HEIGHT)
    for _ in range(frames):
        mask.update(votes, coarse_chroma(image))
    return mask


def plain(colour):
    return np.full((HEIGHT, WIDTH, 3), colour, np.uint8)


def test_the_mask_covers_what_votes_against_the_map_with_a_rim_and_no_more():
    low, high = (200, 120), (300, 220)
    votes = Votes(static_px=everywhere_but(low, high), moving_px=grid_px(low, high))
    mask = masked(votes, plain(TABLE_BGR))
    assert mask.covers(grid_px((190, 110), (290, 210), step=5)).all()
    assert not mask.covers(everywhere_but((150, 70), (350, 270))).any()


def test_one_corner_that_slips_masks_nothing():
    static_px = everywhere_but((0, 0), (1, 1))
    votes = Votes(static_px=static_px, moving_px=np.array([[240.0, 180.0]]))
    assert not masked(votes, plain(TABLE_BGR)).is_moving.any()


def with_arm(background):
    image = plain(background)
    image[200:, 300:360] = SKIN_BGR
    return image


def test_an_arm_is_covered_whole_where_a_part_of_it_is_seen_to_move():
    static_px = everywhere_but((290, 190), (370, HEIGHT))
    votes = Votes(static_px=static_px, moving_px=np.array([[330.0, 215.0], [320.0, 230.0]]))
    mask = masked(votes, with_arm(TABLE_BGR))
    assert mask.covers(grid_px((300, 200), (360, HEIGHT), step=10)).all()
    assert not mask.covers(everywhere_but((270, 170), (390, HEIGHT))).any()


def test_what_has_the_colour_of_skin_but_moves_with_the_map_is_no_hand():
    everything = Votes(static_px=grid_px((10, 10), (WIDTH, HEIGHT)), moving_px=np.empty((0, 2)))
    assert not masked(everything, with_arm(TABLE_BGR)).is_moving.any()
    slipping = Votes(static_px=everything.static_px, moving_px=np.array([[330.0, 300.0]]))
    assert not masked(slipping, plain(SKIN_BGR)).is_moving.any()


def test_a_mask_of_half_of_the_image_is_not_believed():
    votes = Votes(static_px=np.empty((0, 2)), moving_px=grid_px((10, 10), (WIDTH, HEIGHT)))
    assert not masked(votes, plain(GREEN_BGR)).is_moving.any()


def test_a_grey_image_has_no_colours():
    assert coarse_chroma(np.zeros((HEIGHT, WIDTH), np.uint8)) is None
