"""`tags.yaml`: the AprilTags that set the world frame."""

from pathlib import Path

import numpy as np
import yaml

from gazemap.errors import InputError
from gazemap.geometry.pose import Pose, Tag, World
from gazemap.session.atomic import whole_file
from gazemap.session.documents import Document, numbers, read_yaml
from gazemap.types.session import LayoutTag, TagLayout

# How many tags each family has.
FAMILIES = {"tag16h5": 30, "tag25h9": 35, "tag36h10": 2320, "tag36h11": 587}
_MAX_QUATERNION_ERROR = 0.02


def read_tags(path: Path) -> TagLayout:
    """Read a tag layout.

    Raises:
        InputError: if the family is unknown, or a tag is repeated, unknown to it or malformed.
    """
    document = read_yaml(path)
    family = document.get("family")
    if not isinstance(family, str) or family not in FAMILIES:
        raise InputError(
            f"tag family '{family}' is unknown; known: {', '.join(FAMILIES)}",
            where=path,
            todo="correct 'family'",
        )
    if document.get("frame", "world") != "world":
        raise InputError(
            f"'frame' is '{document['frame']}', 'world' expected", where=path, todo="correct it"
        )
    entries = document.get("tags")
    if not isinstance(entries, list) or not entries:
        raise InputError("'tags' must list at least one tag", where=path, todo="add the tags")
    tags = tuple(_tag(entry, f"{path}, tag {i + 1}", family) for i, entry in enumerate(entries))
    if len({tag.tag_id for tag in tags}) < len(tags):
        raise InputError("an id is used twice", where=path, todo="give each tag its own id")
    return TagLayout(family=family, tags=tags)


def write_tags(layout: TagLayout, path: Path) -> None:
    """Write a layout as `read_tags` reads it, whole or not at all."""
    entries = [
        {
            "id": tag.tag_id,
            "size": round(tag.size_m, 6),
            "position": [round(float(x), 6) for x in tag.T_world_tag.t],
            "orientation": [round(float(x), 9) for x in tag.T_world_tag.quat_xyzw],
        }
        for tag in sorted(layout.tags, key=lambda tag: tag.tag_id)
    ]
    document = {"family": layout.family, "frame": "world", "tags": entries}
    with whole_file(path) as partial:
        partial.write_text(yaml.safe_dump(document, sort_keys=False), encoding="utf-8")


def _tag(entry: object, where: str, family: str) -> LayoutTag:
    if not isinstance(entry, dict):
        raise _wrong(where, "id, size, position and orientation expected")
    tag_id = entry.get("id")
    if isinstance(tag_id, bool) or not isinstance(tag_id, int):
        raise _wrong(where, f"'id' must be an integer, got {tag_id!r}")
    if not 0 <= tag_id < FAMILIES[family]:
        raise _wrong(where, f"{family} has no id {tag_id}")
    size_m = numbers(entry, "size", path=where)
    if size_m.size != 1 or size_m[0] <= 0:
        raise _wrong(where, "'size' must be the side of the black square in metres")
    return LayoutTag(tag_id=tag_id, size_m=float(size_m[0]), T_world_tag=_pose(entry, where))


def _pose(entry: Document, where: str) -> Pose[World, Tag]:
    position = numbers(entry, "position", path=where)
    quat_xyzw = numbers(entry, "orientation", path=where)
    if position.size != 3 or quat_xyzw.size != 4:
        raise _wrong(where, "'position' has 3 numbers, 'orientation' 4 (x, y, z, w)")
    if abs(np.linalg.norm(quat_xyzw) - 1) > _MAX_QUATERNION_ERROR:
        raise _wrong(where, "'orientation' must be a unit quaternion x, y, z, w")
    return Pose.from_quat_xyzw(quat_xyzw, position)


def _wrong(where: str, what: str) -> InputError:
    return InputError(what, where=where, todo="correct the tag")
