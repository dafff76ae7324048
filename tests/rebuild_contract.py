"""What INTERFACES promises of a rebuild folder, checked without the code that writes it."""

import csv
import json
import re

import cv2
import numpy as np

FIXATION_HEADER = (
    "fixation id,start timestamp [ns],end timestamp [ns],scene u [px],scene v [px],x [m],y [m],"
    "z [m],cov_xx,cov_xy,cov_xz,cov_yy,cov_yz,cov_zz,hit,object,overhead u [px],overhead v [px],"
    "instruction,probability"
)
PATCH_HEADER = "patch,camera,t_ns,u [px],v [px],instruction,symbols,weight,kept,reason"
INSTRUCTION_KEYS = {
    *("index", "sentence", "action", "target", "location", "start_ns", "end_ns", "status"),
    *("confidence", "object", "target_position", "target_orientation", "target_size"),
    *("target_covariance", "location_position", "location_covariance", "fixations", "patches"),
    *("candidates", "question", "reason"),
}
ACTIONS = {
    *("pick", "place", "move", "push", "pull", "rotate", "open", "close", "pour", "give", "point"),
}
STATUSES = {"grounded", "ambiguous", "unknown-symbol", "ungrounded"}
INTEGER = re.compile(r"-?\d+")


def read_json(path):
    def refuse(word):
        raise AssertionError(f"{path.name}: {word} is no JSON")

    return json.loads(path.read_text(), parse_constant=refuse)


def read_csv(path, header):
    with path.open(newline="") as file:
        rows = csv.DictReader(file)
        table = list(rows)
    assert f"{','.join(rows.fieldnames)},".startswith(f"{header},"), path
    assert not any(None in row or None in row.values() for row in table), path
    return table


def check_covariance(rows):
    cov = np.array(rows, dtype=float)
    assert cov.shape == (3, 3)
    np.testing.assert_allclose(cov, cov.T, atol=1e-12)
    assert np.linalg.eigvalsh(cov).min() > -1e-12


def check_quaternion(values):
    assert len(values) == 4
    assert abs(np.linalg.norm(values) - 1) < 1e-6


def check_trajectory(out, *, scale):
    rows = [line.split(" ") for line in (out / "trajectory.tum").read_text().splitlines()]
    assert all(len(row) == 8 and re.fullmatch(r"\d+\.\d{9}", row[0]) for row in rows)
    times = [int(row[0].replace(".", "")) for row in rows]
    assert times == sorted(set(times))
    for row in rows:
        check_quaternion([float(x) for x in row[4:]])
    beside = read_json(out / "trajectory.json")
    assert beside["frame"] == "world"
    assert beside["scale"] == scale
    assert isinstance(beside["map_id"], int)
    return times


def check_summary(out):
    summary = read_json(out / "summary.json")
    for stage in summary["stages"].values():
        assert stage["status"] in {"ok", "warning", "error"}
        assert all(isinstance(message, str) for message in stage["messages"])
        assert stage["seconds"] >= 0
    frames = summary["frames"]
    assert frames["seen"] == frames["tracked"] + frames["lost"]
    assert summary["scale"] in {"metric", "arbitrary"}
    assert len(summary["gaze_offset_deg"]) == len(summary["gaze_offset_sigma_deg"]) == 2
    assert summary["versions"]
    return summary


def check_objects(out):
    objects = read_json(out / "objects.json")["objects"]
    for each in objects:
        assert isinstance(each["symbols"], list)
        assert len(each["size"]) == 3
        assert min(each["size"]) > 0
        assert each["track"]
        times = [state["t_ns"] for state in each["track"]]
        assert times == sorted(set(times))
        for state in each["track"]:
            assert len(state["position"]) == 3
            check_quaternion(state["orientation"])
            assert state["orientation"][:2] == [0, 0]  # yaw alone
            check_covariance(state["covariance"])
    ids = [each["id"] for each in objects]
    assert len(ids) == len(set(ids))
    return set(ids)


def check_fixations(out, *, object_ids, count):
    rows = read_csv(out / "fixations3d.csv", FIXATION_HEADER)
    ids = [row["fixation id"] for row in rows]
    assert len(ids) == len(set(ids))
    for row in rows:
        names = ("fixation id", "start timestamp [ns]", "end timestamp [ns]")
        assert all(INTEGER.fullmatch(row[name]) for name in names)
        assert int(row["start timestamp [ns]"]) <= int(row["end timestamp [ns]"])
        assert row["hit"] in {"surface", "object", "none"}
        assert (row["object"] in object_ids) if row["hit"] == "object" else row["object"] == ""
        point = [row[f"{axis} [m]"] for axis in "xyz"]
        cov = [row[f"cov_{pair}"] for pair in ("xx", "xy", "xz", "yy", "yz", "zz")]
        if row["hit"] == "none":
            assert not any([*point, *cov])
        else:
            assert all(np.isfinite([float(x) for x in point]))
            xx, xy, xz, yy, yz, zz = (float(x) for x in cov)
            check_covariance([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        assert row["instruction"] == "" or 0 <= int(row["instruction"]) < count
        assert row["probability"] == "" or 0 <= float(row["probability"]) <= 1
    return {int(each) for each in ids}


def check_instruction(each, *, index, known):
    assert set(each) >= INSTRUCTION_KEYS
    assert each["index"] == index
    assert each["action"] in ACTIONS
    assert each["target"]
    assert each["target"] == [word.lower() for word in each["target"]]
    assert isinstance(each["location"], str)
    assert " " not in each["location"]
    assert each["status"] in STATUSES
    assert 0 <= each["confidence"] <= 1
    assert set(each["fixations"]) <= known["fixations"]
    assert set(each["patches"]) <= known["patches"]
    if each["status"] == "grounded":
        assert each["object"] in known["objects"]
        assert each["start_ns"] <= each["end_ns"]
        check_quaternion(each["target_orientation"])
        assert len(each["target_position"]) == len(each["location_position"]) == 3
        assert min(each["target_size"]) > 0
        check_covariance(each["target_covariance"])
        check_covariance(each["location_covariance"])
        if each["action"] == "pick":
            assert each["location_position"] == each["target_position"]
    if each["status"] == "ungrounded":
        assert each["reason"]
    if each["status"] == "ambiguous":
        assert each["candidates"]
    if each["status"] == "unknown-symbol":
        assert each["question"]


def check_patches(out, *, count):
    rows = read_csv(out / "patches.csv", PATCH_HEADER)
    for row in rows:
        assert row["camera"] in {"overhead", "head"}
        assert row["kept"] in {"0", "1"}
        assert row["kept"] == "1" or row["reason"]
        assert 0 <= int(row["instruction"]) < count
        assert row["symbols"].split(" ")
        if row["kept"] == "1":
            assert cv2.imread(str(out / "patches" / row["patch"])) is not None
            assert np.isfinite([float(row["u [px]"]), float(row["v [px]"])]).all()
    names = [row["patch"] for row in rows]
    assert len(names) == len(set(names))
    assert {path.name for path in (out / "patches").iterdir()} <= set(names)
    return {row["patch"] for row in rows if row["kept"] == "1"}


def check_symbols(out):
    document = read_json(out / "symbols.json")
    words = document["symbols"]
    for each in words.values():
        size = len(each["features"])
        assert len(each["mean"]) == size
        assert np.shape(each["covariance"]) == (size, size)
        assert each["kept"] >= 0
        assert each["dropped"] >= 0
        assert each["group"] in document["groups"]
    assert all(set(group) <= set(words) for group in document["groups"].values())


def check_mesh(out):
    header = (out / "scene.ply").read_bytes()[:600].partition(b"end_header")[0].decode()
    lines = header.splitlines()
    assert lines[0] == "ply"
    assert {"property uchar red", "property uchar green", "property uchar blue"} <= set(lines)
    counts = dict(line.split()[1:] for line in lines if line.startswith("element"))
    assert int(counts["vertex"]) > 0
    assert int(counts["face"]) > 0


def check_report(out, *, scale, least_pictures):
    page = (out / "report.html").read_text()
    assert f"scale {scale}" in page
    assert scale == "metric" or not re.search(r"\[m?m\]|in m\.", page)
    assert not re.search(r"""(src|href)=["'](?!data:|#)""", page)
    assert page.count("data:image/png;base64,") >= least_pictures


def assert_rebuild_is_as_promised(out, *, scale, least_pictures=3):
    """Check every file of a finished rebuild."""
    summary = check_summary(out)
    assert summary["scale"] == scale
    times = check_trajectory(out, scale=scale)
    assert len(times) == summary["frames"]["tracked"]
    import pycolmap

    assert pycolmap.Reconstruction(str(out / "map")).num_points3D() > 0
    check_mesh(out)
    plan = read_json(out / "plan.json")
    assert set(plan) >= {"session", "revision", "frame", "scale", "symbols", "unparsed"}
    assert (plan["frame"], plan["scale"]) == ("world", scale)
    count = len(plan["instructions"])
    known = {"objects": check_objects(out), "patches": check_patches(out, count=count)}
    known["fixations"] = check_fixations(out, object_ids=known["objects"], count=count)
    for index, each in enumerate(plan["instructions"]):
        check_instruction(each, index=index, known=known)
    assert {word for each in plan["instructions"] for word in each["target"]} <= set(
        plan["symbols"]
    )
    assert all({"sentence", "reason"} <= set(each) for each in plan["unparsed"])
    check_symbols(out)
    check_report(out, scale=scale, least_pictures=least_pictures)
