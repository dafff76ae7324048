"""Spreading a loop's error over the keyframes: a pose graph over similarities, by gtsam.

Without tags the scale drifts as position and heading do, so every keyframe has one of its own.
A gtsam Similarity3 maps p to s (R p + t); ours maps it to s R p + t.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from gazemap.geometry.align import Similarity
from gazemap.geometry.pose import Cam, Pose, World

if TYPE_CHECKING:
    import gtsam

_TURN_SIGMA = 0.01
_SCALE_SIGMA = 0.02
_FIXED_SIGMA = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LoopEdge:
    """Keyframe `there` as keyframe `here` of the old part of the map sees it."""

    here: int
    there: int
    S_here_there: Similarity[Cam, Cam]


def close_loops(
    T_world_cam: Mapping[int, Pose[World, Cam]],
    edges: Sequence[tuple[int, int]],
    loops: Sequence[LoopEdge],
    *,
    depth: float,
    metric: bool,
) -> dict[int, Similarity[World, Cam]]:
    """Return where each keyframe goes, and how its surroundings grow.

    Args:
        T_world_cam: keyframes as they are.
        edges: pairs whose relative pose is to be kept.
        loops: what closes the loops; the first one's `here` stays where it is.
        depth: typical distance of points, which makes turns and paths comparable.
        metric: whether the scale is known and stays.
    """
    import gtsam

    graph, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
    nodes = {k: _to_gtsam(Similarity(scale=1.0, R=T.R, t=T.t)) for k, T in T_world_cam.items()}
    for k, node in nodes.items():
        values.insert(k, node)
    scale_sigma = _FIXED_SIGMA if metric else _SCALE_SIGMA
    sigmas = np.array([_TURN_SIGMA] * 3 + [_TURN_SIGMA * depth] * 3 + [scale_sigma])
    noise = gtsam.noiseModel.Diagonal.Sigmas(sigmas)
    for i, j in edges:
        graph.add(gtsam.BetweenFactorSimilarity3(i, j, nodes[i].inverse() * nodes[j], noise))
    tight = gtsam.noiseModel.Diagonal.Sigmas(0.3 * sigmas)
    for loop in loops:
        between = _to_gtsam(loop.S_here_there)
        graph.add(gtsam.BetweenFactorSimilarity3(loop.here, loop.there, between, tight))
    anchor = loops[0].here
    fixed = gtsam.noiseModel.Isotropic.Sigma(7, _FIXED_SIGMA)
    graph.add(gtsam.PriorFactorSimilarity3(anchor, nodes[anchor], fixed))
    solved = gtsam.LevenbergMarquardtOptimizer(graph, values).optimize()
    return {k: _from_gtsam(solved.atSimilarity3(k)) for k in nodes}


def _to_gtsam(S: Similarity[World, Cam] | Similarity[Cam, Cam]) -> "gtsam.Similarity3":
    import gtsam

    return gtsam.Similarity3(gtsam.Rot3(S.R), S.t / S.scale, S.scale)


def _from_gtsam(S: "gtsam.Similarity3") -> Similarity[World, Cam]:
    scale = float(S.scale())
    U, _, Vt = np.linalg.svd(S.rotation().matrix())
    return Similarity(scale=scale, R=U @ Vt, t=scale * np.asarray(S.translation()))
