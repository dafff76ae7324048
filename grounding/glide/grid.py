"""Positions where vision has no instance: a grid on the table, summed over."""

from dataclasses import dataclass

import numpy as np
from numba import njit

from grounding.glide.config import GlideConfig
from grounding.glide.model import Parameters, Session
from grounding.glide.sight import where_met
from grounding.types import FloatArray, IntArray

_NODES_MOST = 20_000
_HEIGHT_SIGMA_M = 0.008
_RATIO_CAP = 5e3
_SEEN = 1e-3  # a look whose density ratio at a node is below this says nothing for the node


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Grid:
    """Nodes of a level grid and what each look says for them; sparse, one run of nodes a look.

    Attributes:
        nodes: (G, 3) positions.
        first: (T + 1,) where each look's run begins.
        node: (S,) node of each entry.
        ratio: (S,) density of the look for that node over that of the background.
        spacing: between neighbours, metres.
    """

    nodes: FloatArray
    first: IntArray
    node: IntArray
    ratio: FloatArray
    spacing: float

    @staticmethod
    def over(session: Session, parameters: Parameters, config: GlideConfig) -> "Grid":
        """Lay the grid over the workspace, at the height of a small thing's middle."""
        unit = config.scene_unit_m
        extent = session.high - session.low
        spacing = max(config.grid_spacing_m * unit, float(np.sqrt(extent.prod() / _NODES_MOST)))
        x, y = (
            np.arange(lo, hi + spacing, spacing)
            for lo, hi in zip(session.low, session.high, strict=True)
        )
        height = session.table_z + config.rest_height_m * unit
        nodes = np.stack(
            [*np.meshgrid(x, y, indexing="ij"), np.full((len(x), len(y)), height)], axis=-1
        ).reshape(-1, 3)
        met, cov = where_met(session.sights, height, offset_rad=parameters.gaze_offset_rad)
        spread = (config.aim_sigma_m * unit) ** 2 + (_HEIGHT_SIGMA_M * unit) ** 2
        cov = parameters.noise_scale**2 * cov + (spread + spacing**2 / 12) * np.eye(2)
        first, node, ratio = _near_nodes(nodes, met, cov, session.area)
        return Grid(nodes=nodes, first=first, node=node, ratio=ratio, spacing=spacing)


def _near_nodes(
    nodes: FloatArray, met: FloatArray, cov: FloatArray, area: float
) -> tuple[IntArray, IntArray, FloatArray]:
    first, rows, values = [0], [], []
    for point, spread in zip(met, cov, strict=True):
        if np.isfinite(point).all():
            off = nodes[:, :2] - point[:2]
            squared = np.einsum("gi,ij,gj->g", off, np.linalg.inv(spread), off)
            ratio = area * np.exp(-0.5 * squared) / (2 * np.pi * np.sqrt(np.linalg.det(spread)))
            near = np.flatnonzero(ratio > _SEEN)
            rows.append(near)
            values.append(np.minimum(ratio[near], _RATIO_CAP))
        first.append(first[-1] + (len(rows[-1]) if np.isfinite(point).all() else 0))
    node = np.concatenate(rows) if rows else np.zeros(0, dtype=np.int64)
    ratio_all = np.concatenate(values) if values else np.zeros(0)
    return np.array(first, dtype=np.int64), node.astype(np.int64), ratio_all


def grid_segments(grid: Grid, base: FloatArray, weight: FloatArray, *, longest: int) -> FloatArray:
    """Return (rows, T, D + 1): log likelihood of every segment, its position summed out, eq. 5.

    Args:
        grid: the nodes.
        base: (rows, T) what else a look may be.
        weight: (rows,) weight of the position's component.
        longest: D.

    Returns:
        Logs relative to the background.
    """
    table = np.zeros((len(base), base.shape[1], longest + 1))
    for row in range(len(base)):
        _fill(
            table[row], (grid.first, grid.node, grid.ratio), base[row], weight[row], len(grid.nodes)
        )
    return table


@njit(cache=True)
def _fill(
    table: FloatArray,
    runs: tuple[IntArray, IntArray, FloatArray],
    base: FloatArray,
    weight: float,
    nodes: int,
) -> None:
    first, node, ratio = runs
    count, longest = table.shape[0], table.shape[1] - 1
    product = np.ones(nodes)
    for s in range(count):
        total, log_base = float(nodes), 0.0
        e = min(count, s + longest)
        for t in range(s, e):
            log_base += np.log(base[t])
            for k in range(first[t], first[t + 1]):
                before = product[node[k]]
                product[node[k]] = before * (1.0 + weight * ratio[k] / base[t])
                total += product[node[k]] - before
            table[s, t + 1 - s] = log_base + np.log(total / nodes)
        for t in range(s, e):
            for k in range(first[t], first[t + 1]):
                product[node[k]] = 1.0


@njit(cache=True)
def read_grid(
    weights: FloatArray,
    runs: tuple[IntArray, IntArray, FloatArray],
    base: FloatArray,
    weight: float,
    nodes: int,
) -> tuple[FloatArray, FloatArray]:
    """Return what segments with posterior weights (T, D + 1) say of the position.

    Returns:
        belief: (nodes,) posterior of the position, its sum that of the weights.
        on_place: (T,) posterior that the look was at the position.
    """
    first, node, ratio = runs
    count, longest = weights.shape[0], weights.shape[1] - 1
    belief, on_place = np.zeros(nodes), np.zeros(count)
    for s in range(count):
        for d in range(1, longest + 1):
            w = weights[s, d]
            if w < 1e-9:
                continue
            product = np.ones(nodes)
            for t in range(s, s + d):
                for k in range(first[t], first[t + 1]):
                    product[node[k]] *= 1.0 + weight * ratio[k] / base[t]
            product *= w / product.sum()
            belief += product
            for t in range(s, s + d):
                for k in range(first[t], first[t + 1]):
                    pull = weight * ratio[k] / base[t]
                    on_place[t] += product[node[k]] * pull / (1.0 + pull)
    return belief, on_place
