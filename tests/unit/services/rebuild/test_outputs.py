import csv
import json

import numpy as np
import pytest

from gazemap.geometry.pose import Pose
from gazemap.types.fixation import Fixation3D
from gazemap.types.scene import HitKind, ObjectState, SceneObject
from gazemap.types.session import Fixation
from services.rebuild.outputs import (
    Membership,
    objects_document,
    write_fixations,
    write_json,
)

HEADER = (
    "fixation id,start timestamp [ns],end timestamp [ns],scene u [px],scene v [px],"
    "x [m],y [m],z [m],cov_xx,cov_xy,cov_xz,cov_yy,cov_yz,cov_zz,hit,object,"
    "overhead u [px],overhead v [px],instruction,probability"
)
T0_NS = 1_760_000_000_000_000_000


def fixation3d(*, hit):
    seen = hit is not HitKind.NONE
    return Fixation3D(
        fixation=Fixation(fixation_id=7, start_ns=T0_NS, end_ns=T0_NS + 9, u_px=1.0, v_px=2.0),
        scene_uv_px=np.array([1.5, 2.5]),
        hit=hit,
        point_world=np.array([0.1, -0.2, 0.03]) if seen else None,
        cov_world=np.array([[4, 1, 2], [1, 5, 3], [2, 3, 6]]) * 1e-6 if seen else None,
        object_id="object-1" if hit is HitKind.OBJECT else None,
        overhead_uv_px=np.array([300.0, 200.0]) if seen else None,
    )


def read(path):
    return list(csv.DictReader(path.read_text().splitlines()))


def test_fixations_have_the_promised_header_and_whole_nanoseconds(tmp_path):
    members = {7: Membership(instruction=2, probability=0.9)}
    write_fixations(tmp_path / "f.csv", [fixation3d(hit=HitKind.OBJECT)], members)
    assert (tmp_path / "f.csv").read_text().splitlines()[0] == HEADER
    row = read(tmp_path / "f.csv")[0]
    assert row["start timestamp [ns]"] == str(T0_NS)
    assert (row["hit"], row["object"], row["instruction"]) == ("object", "object-1", "2")
    assert float(row["cov_yz"]) == pytest.approx(3e-6)


def test_what_is_not_known_is_an_empty_field(tmp_path):
    write_fixations(tmp_path / "f.csv", [fixation3d(hit=HitKind.NONE)], {})
    row = read(tmp_path / "f.csv")[0]
    for column in ("x [m]", "cov_xx", "object", "overhead u [px]", "instruction", "probability"):
        assert row[column] == "", column
    assert row["hit"] == "none"


def test_objects_tell_where_they_came_to_rest():
    state = ObjectState(
        t_ns=T0_NS,
        left_ns=None,
        T_world_body=Pose.from_rotvec([0, 0, np.pi / 2], [0.1, 0.2, 0.025]),
        cov_world=np.eye(3) * 1e-6,
    )
    thing = SceneObject(
        object_id="object-1", size_m=np.full(3, 0.05), track=(state,), mean_bgr=np.zeros(3)
    )
    document = objects_document([thing], {"object-1": ["red", "cube"]})["objects"][0]
    assert document["symbols"] == ["red", "cube"]
    assert document["track"][0]["orientation"] == pytest.approx([0, 0, 0.5**0.5, 0.5**0.5])
    assert document["track"][0]["position"] == [0.1, 0.2, 0.025]


def test_json_refuses_what_json_cannot_say_and_leaves_nothing(tmp_path):
    with pytest.raises(ValueError, match="JSON"):
        write_json(tmp_path / "a.json", {"x": float("nan")})
    assert list(tmp_path.iterdir()) == []
    write_json(tmp_path / "a.json", {"x": None})
    assert json.loads((tmp_path / "a.json").read_text()) == {"x": None}
