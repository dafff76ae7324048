"""The files of a rebuild folder that tell of the mapping: objects, fixations and the summary."""

import csv
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from gazemap.session.atomic import whole_file
from gazemap.types.fixation import Fixation3D
from gazemap.types.scene import SceneObject

_FIXATION_COLUMNS = [
    "fixation id",
    "start timestamp [ns]",
    "end timestamp [ns]",
    "scene u [px]",
    "scene v [px]",
    "x [m]",
    "y [m]",
    "z [m]",
    "cov_xx",
    "cov_xy",
    "cov_xz",
    "cov_yy",
    "cov_yz",
    "cov_zz",
    "hit",
    "object",
    "overhead u [px]",
    "overhead v [px]",
    "instruction",
    "probability",
]
_UPPER_TRIANGLE = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))


@dataclass(frozen=True, slots=True, kw_only=True)
class Membership:
    """Which instruction a fixation belongs to, or None, and how probable that is."""

    instruction: int | None
    probability: float


def write_json(path: Path, document: Mapping[str, object]) -> None:
    """Write a JSON document, whole or not at all."""
    with whole_file(path) as partial:
        partial.write_text(json.dumps(document, indent=1, allow_nan=False) + "\n")


def write_rows(path: Path, columns: Sequence[str], rows: Sequence[Mapping[str, object]]) -> None:
    """Write a csv file with the given header, whole or not at all."""
    with whole_file(path) as partial, partial.open("w", newline="") as file:
        writer = csv.DictWriter(file, columns, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def objects_document(
    objects: Sequence[SceneObject], symbols: Mapping[str, Sequence[str]]
) -> dict[str, object]:
    """Return objects.json: each object's size, its words and where it came to rest."""
    return {
        "objects": [
            {
                "id": each.object_id,
                "symbols": list(symbols.get(each.object_id, ())),
                "size": each.size_m.tolist(),
                "track": [
                    {
                        "t_ns": state.t_ns,
                        "position": state.T_world_body.t.tolist(),
                        "orientation": state.T_world_body.quat_xyzw.tolist(),
                        "covariance": state.cov_world.tolist(),
                    }
                    for state in each.track
                ],
            }
            for each in objects
        ]
    }


def write_fixations(
    path: Path, fixations: Sequence[Fixation3D], memberships: Mapping[int, Membership]
) -> None:
    """Write fixations3d.csv; a fixation without a membership has empty fields there."""
    rows = [_fixation_row(each, memberships.get(each.fixation.fixation_id)) for each in fixations]
    write_rows(path, _FIXATION_COLUMNS, rows)


def _fixation_row(each: Fixation3D, member: Membership | None) -> dict[str, object]:
    point = [""] * 3 if each.point_world is None else [f"{x:.6f}" for x in each.point_world]
    cov: list[str] = [""] * 6
    if each.cov_world is not None:
        # Nine digits keep a rank-deficient rounding away: some spreads are below a millimetre.
        cov = [f"{each.cov_world[i, j]:.9e}" for i, j in _UPPER_TRIANGLE]
    overhead = each.overhead_uv_px
    values = [
        each.fixation.fixation_id,
        each.fixation.start_ns,
        each.fixation.end_ns,
        *(f"{x:.3f}" if math.isfinite(x) else "" for x in each.scene_uv_px),
        *point,
        *cov,
        each.hit.value,
        each.object_id or "",
        *(["", ""] if overhead is None else [f"{x:.3f}" for x in overhead]),
        "" if member is None or member.instruction is None else member.instruction,
        "" if member is None else f"{member.probability:.4f}",
    ]
    return dict(zip(_FIXATION_COLUMNS, values, strict=True))
