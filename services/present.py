"""The present scene: the things on the table now and what each may be called."""

from collections.abc import Mapping, Sequence

import numpy as np

from grounding.features.registry import PatchFeatures, extract_features
from grounding.patches.cut import PatchConfig, Showing, cut_patches
from grounding.patches.view import View
from grounding.pipeline import SessionGrounding
from grounding.plan import Status
from grounding.query import NamedThing, PresentScene
from grounding.symbols.classify import Classifier
from grounding.symbols.model import SymbolModel
from grounding.symbols.teach import Question, questions
from grounding.types import ObjectInstance

# A calibrated classifier that says "known" is right about that often.
_CLASSIFIED = 0.97
_LATELY_NS = 1_000_000_000
_ONE_LOOK = PatchConfig(per_showing=1, looked_at=1, sure=0.0)


def present_scene(
    grounded: SessionGrounding | None,
    objects: Sequence[ObjectInstance],
    model: SymbolModel,
    *,
    view: View | None,
    heading_rad: float,
) -> PresentScene:
    """Name the things that stand on the table: by what was said of them, and by how they look."""
    standing = [each for each in objects if each.track[-1].left_ns is None]
    said = {} if grounded is None else _said(grounded)
    classifier = Classifier(model)
    things = []
    for each in standing:
        words = dict(said.get(each.object_id, {}))
        features = None if is_covered(each, standing) else look_at(each, view)
        if features is not None:
            for found in classifier.classify(features):
                if found.known:
                    words[found.symbol] = max(words.get(found.symbol, 0.0), _CLASSIFIED)
        things.append(NamedThing(instance=each, words=words))
    known = {word for names in said.values() for word in names} | set(model.words)
    return PresentScene(
        things=things,
        known_words=frozenset(known),
        seen=() if grounded is None else grounded.relations,
        heading_rad=heading_rad,
    )


def _said(grounded: SessionGrounding) -> Mapping[str, dict[str, float]]:
    """Return, for each object of a grounded instruction, its words and how sure they are."""
    said: dict[str, dict[str, float]] = {}
    for each in grounded.plan.instructions:
        if each.status is Status.GROUNDED and each.target and each.target.object_id:
            words = said.setdefault(each.target.object_id, {})
            for word in each.spoken.instruction.target:
                words[word] = max(words.get(word, 0.0), each.confidence)
    return said


def strange_things(
    objects: Sequence[ObjectInstance], model: SymbolModel, *, view: View | None
) -> tuple[tuple[str, Question], ...]:
    """Return the things on the table that no word of a group explains, each with what to ask."""
    classifier = Classifier(model)
    standing = [each for each in objects if each.track[-1].left_ns is None]
    found = []
    for each in standing:
        features = None if is_covered(each, standing) else look_at(each, view)
        if features is not None:
            asked = questions(model, classifier.classify(features))
            found += [(each.object_id, question) for question in asked]
    return tuple(found)


def is_covered(thing: ObjectInstance, others: Sequence[ObjectInstance]) -> bool:
    """Return whether another thing stands on this one: from above one would see that other."""
    x, y, z = thing.track[-1].position_world
    for other in others:
        place = other.track[-1]
        above_x, above_y, above_z = place.position_world
        apart_m = np.hypot(above_x - x, above_y - y)
        is_above = above_z > z and apart_m < min(other.size_m[0], other.size_m[1]) / 2
        if place.left_ns is None and other.object_id != thing.object_id and is_above:
            return True
    return False


def look_at(thing: ObjectInstance, view: View | None) -> PatchFeatures | None:
    """Return what a thing looks like in the camera's last images, or None if it is not seen."""
    if view is None or not view.t_ns:
        return None
    place, now_ns = thing.track[-1], view.t_ns[-1]
    showing = Showing(
        instruction=0,
        symbols=(),
        weight=1.0,
        object_id=thing.object_id,
        position_world=place.position_world,
        quat_xyzw=place.quat_xyzw,
        size_m=thing.size_m,
        since_ns=max(place.t_ns, now_ns - _LATELY_NS),
        until_ns=now_ns,
        is_looked_at=True,
    )
    for patch in cut_patches([showing], view, _ONE_LOOK):
        if patch.kept and patch.image_bgr is not None:
            found = extract_features(
                patch.image_bgr, mm_per_px=patch.mm_per_px, height_mm=patch.height_mm
            )
            return found if isinstance(found, PatchFeatures) else None
    return None
