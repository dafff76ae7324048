"""Writes what is true of a simulated session: truth.json and trajectory.tum."""

import json
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from gazemap.geometry.arrays import FloatArray
from gazemap.geometry.pose import Overhead, Pose, World
from gazemap.sim.config import SimConfig
from gazemap.sim.eyes import Look
from gazemap.sim.head import HeadPath
from gazemap.sim.recording import START_NS, to_ns
from gazemap.sim.tabletop import Demonstration, Step


def write_trajectory(path: Path, head: HeadPath, t_s: FloatArray) -> None:
    """Write the camera's true poses at times (N,) as TUM rows."""
    R, p = head.poses(t_s)
    quat = Rotation.from_matrix(R).as_quat(canonical=True)
    rows = []
    for t, position, q in zip(t_s, p, quat, strict=True):
        seconds, rest_ns = divmod(to_ns(t), 10**9)
        numbers = " ".join(f"{x:.9f}" for x in (*position, *q))
        rows.append(f"{seconds}.{rest_ns:09d} {numbers}\n")
    path.write_text("".join(rows), encoding="utf-8")


def truth_document(
    config: SimConfig,
    demonstration: Demonstration,
    looks: tuple[Look, ...],
    *,
    T_world_overhead: Pose[World, Overhead],
    offset_px: FloatArray,
) -> dict[str, object]:
    """Return the content of truth.json."""
    final = demonstration.centres_world(np.inf)
    return {
        "seed": config.seed,
        "level": str(config.level),
        "T0": START_NS,
        "plan": [_plan_row(step, demonstration) for step in demonstration.steps],
        "fixations": [
            {
                "id": i + 1,
                "start_ns": to_ns(look.start_s),
                "end_ns": to_ns(look.end_s),
                "point": look.point_world.tolist(),
                "instruction": -1 if look.instruction is None else look.instruction,
            }
            for i, look in enumerate(looks)
        ],
        "objects": [
            {
                "colour": block.colour,
                "shape": block.shape,
                "size": block.size_m.tolist(),
                "start": block.T_world_body(block.start_world).tolist(),
                "end": block.T_world_body(end).tolist(),
            }
            for block, end in zip(demonstration.blocks, final, strict=True)
        ],
        "T_world_overhead": T_world_overhead.matrix.tolist(),
        "gaze_bias_px": offset_px.tolist(),
    }


def _plan_row(step: Step, demonstration: Demonstration) -> dict[str, object]:
    row: dict[str, object] = {
        "action": str(step.action),
        "target": list(demonstration.blocks[step.block].words),
        "object": step.block,
    }
    if step.relation is not None:
        row |= {"reference": step.reference, "relation": str(step.relation)}
    return row | {
        "start": step.start_s,
        "end": step.end_s,
        "sentence": step.sentence,
        "position": step.position_world.tolist(),
    }


def write_truth(path: Path, document: dict[str, object]) -> None:
    """Write truth.json."""
    path.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
