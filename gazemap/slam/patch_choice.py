"""Which points get patches: well seen, and spread over every keyframe."""

from dataclasses import dataclass

import numpy as np

from gazemap.geometry.arrays import FloatArray, IntArray
from gazemap.geometry.camera import Camera
from gazemap.slam.config import PatchConfig
from gazemap.slam.front import Skeleton
from gazemap.slam.patches import PatchViews
from gazemap.slam.structure import Structure

_FEWEST_KEYFRAMES = 3
_CELLS = 6
_VIEW_SAMPLES = 60
_NEW_SHARE = 0.5


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PatchPoints:
    """The points that get patches.

    Attributes:
        track: (P,) their tracks in the structure.
        reference: (P,) keyframe each patch is cut from.
        uv_px: (P, 2) its centre there.
    """

    track: IntArray
    reference: IntArray
    uv_px: FloatArray


def candidate_points(skeleton: Skeleton, camera: Camera, config: PatchConfig) -> PatchPoints:
    """Return long-followed points that keyframes should show, more than will be kept."""
    structure = skeleton.structure
    rows = np.flatnonzero(
        structure.is_valid & structure.has_point[structure.track]
        & structure.is_posed[structure.keyframe]
    )  # fmt: skip
    rows = rows[np.argsort(structure.track[rows], kind="stable")]
    start = np.searchsorted(structure.track[rows], np.arange(len(structure.has_point) + 1))
    length = np.diff(start)
    tracks = np.argsort(-length, kind="stable")[: int((length >= _FEWEST_KEYFRAMES).sum())]
    cells = _cells_in_view(structure, camera, tracks=tracks)
    tracks = tracks[_spread(cells, wanted_in_view=config.candidates_in_view)]
    # The view in the middle is nearest to all others.
    middle = rows[(start[tracks] + start[tracks + 1]) // 2]
    return PatchPoints(
        track=tracks, reference=structure.keyframe[middle], uv_px=skeleton.uv_px[middle]
    )


def choose_found(
    found: list[PatchViews], candidates: PatchPoints, *, camera: Camera, config: PatchConfig
) -> IntArray:
    """Return the candidates (Q,) that keyframes found most often, ascending.

    Args:
        found: what each keyframe found of the candidates.
        candidates: the points.
        camera: the head camera.
        config: how many are wanted.
    """
    cells = np.full((len(found), len(candidates.track)), -1, dtype=np.int64)
    for row, views in enumerate(found):
        cells[row, views.point] = _cell_of(views.uv_px, camera)
    count = (cells >= 0).sum(axis=0)
    order = np.argsort(-count, kind="stable")[: int((count >= _FEWEST_KEYFRAMES).sum())]
    return np.sort(order[_spread(cells[:, order], wanted_in_view=config.points_in_view)])


def _cells_in_view(structure: Structure, camera: Camera, *, tracks: IntArray) -> IntArray:
    """Return in which part of the image some keyframes (K,) show tracks (T,); -1 out of view."""
    posed = np.flatnonzero(structure.is_posed)
    sample = posed[:: max(1, len(posed) // _VIEW_SAMPLES)]
    cells = np.full((len(sample), len(tracks)), -1, dtype=np.int64)
    for row, k in enumerate(sample.tolist()):
        in_cam = structure.points_map[tracks] @ structure.R_cam_map[k].T + structure.t_cam_map[k]
        uv_px = camera.project(in_cam)
        seen = camera.contains(uv_px)
        cells[row, seen] = _cell_of(uv_px[seen], camera)
    return cells


def _cell_of(uv_px: FloatArray, camera: Camera) -> IntArray:
    column, row = (uv_px * _CELLS / [camera.width_px, camera.height_px]).astype(np.int64).T
    cell: IntArray = np.clip(row, 0, _CELLS - 1) * _CELLS + np.clip(column, 0, _CELLS - 1)
    return cell


def _spread(cells: IntArray, *, wanted_in_view: int) -> IntArray:
    """Return which columns (Q,) fill the cells of the rows evenly, the first columns first.

    Args:
        cells: (K, P) the part of image k that shows point p; -1 out of view.
        wanted_in_view: so many points an image are enough.
    """
    wanted = np.full((len(cells), _CELLS * _CELLS), wanted_in_view / _CELLS**2)
    chosen = []
    for j, cell in enumerate(np.ascontiguousarray(cells.T)):
        views = np.flatnonzero(cell >= 0)
        if len(views) and (wanted[views, cell[views]] > 0).mean() >= _NEW_SHARE:
            wanted[views, cell[views]] -= 1
            chosen.append(j)
    return np.array(chosen, dtype=np.int64)
