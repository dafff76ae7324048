import pytest

from grounding.places import parse_location


@pytest.mark.parametrize(
    ("symbol", "relation", "landmarks"),
    [
        ("on-top-of-blue-cell", "on-top-of", (("blue", "cell"),)),
        ("to-left-of-red-cube", "left-of", (("red", "cube"),)),
        ("on-left-of-cube", "left-of", (("cube",),)),
        ("in-front-of-cell", "in-front-of", (("cell",),)),
        ("between-red-cube-and-blue-cell", "between", (("red", "cube"), ("blue", "cell"))),
        ("in-box", "in", (("box",),)),
        ("blue-cube-location", None, ()),
        ("red", None, ()),
        ("on-left-hand-side-of-red-cube", "left-of", (("red", "cube"),)),
        ("over-to-red-cube", "near", (("red", "cube"),)),
        ("over-red-cube", "on-top-of", (("red", "cube"),)),
        ("up-against-wall", "near", (("wall",),)),
        ("underneath-red-cube", "under", (("red", "cube"),)),
        ("away-from-red-cube", "away-from", (("red", "cube"),)),
        ("between-red-cube", "between", (("red", "cube"),)),
    ],
)
def test_a_location_symbol_is_taken_apart(
    symbol: str, relation: str | None, landmarks: tuple[tuple[str, ...], ...]
) -> None:
    place = parse_location(symbol)
    assert (place.relation, place.landmarks) == (relation, landmarks)


@pytest.mark.parametrize(
    ("symbol", "landmarks", "described"),
    [
        ("to-left-of-cube-on-blue-block", (("cube",),), ("on-blue-block",)),
        ("between-cube-in-box-and-cell", (("cube",), ("cell",)), ("in-box", None)),
        ("on-cube", (("cube",),), (None,)),
    ],
)
def test_a_landmark_is_told_apart_from_what_describes_it(
    symbol: str, landmarks: tuple[tuple[str, ...], ...], described: tuple[str | None, ...]
) -> None:
    place = parse_location(symbol)
    assert (place.landmarks, place.described) == (landmarks, described)
