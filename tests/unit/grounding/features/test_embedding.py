from pathlib import Path

import numpy as np
import pytest

from grounding.errors import InputError
from grounding.features.embedding import EMBEDDING_SIZE, Embedding
from grounding.features.registry import PatchFeatures, extract_features


def field(number: int, content: bytes | str | int) -> bytes:
    """Return a field of a protobuf message; ONNX files are such messages."""
    if isinstance(content, int):
        return bytes([number << 3, content])
    body = content.encode() if isinstance(content, str) else content
    assert len(body) < 128
    return bytes([number << 3 | 2, len(body)]) + body


def pooling_network() -> bytes:
    """Return an ONNX network that gives the mean of each channel."""

    def value(name: str, shape: tuple[int, ...]) -> bytes:
        dimensions = b"".join(field(1, field(1, size)) for size in shape)
        tensor = field(1, 1) + field(2, dimensions)
        return field(1, name) + field(2, field(1, tensor))

    node = field(1, "x") + field(2, "y") + field(4, "GlobalAveragePool")
    graph = field(1, node) + field(2, "g")
    graph += field(11, value("x", (1, 3, 32, 32))) + field(12, value("y", (1, 3, 1, 1)))
    return field(1, 8) + field(8, field(1, "") + field(2, 13)) + field(7, graph)


def patch(bgr: tuple[int, int, int]) -> np.ndarray:
    image = np.full((96, 96, 3), (90, 130, 170), np.uint8)
    image[30:66, 30:66] = bgr
    return image


def test_a_network_of_the_users_gives_sixteen_features(tmp_path: Path):
    path = tmp_path / "net.onnx"
    path.write_bytes(pooling_network())
    network = Embedding(path, side_px=32)
    vectors = []
    for bgr in ((30, 30, 200), (32, 30, 198), (200, 60, 30)):
        features = extract_features(patch(bgr), embedding=network)
        assert isinstance(features, PatchFeatures)
        vectors.append([features[f"embedding {k + 1}"] for k in range(EMBEDDING_SIZE)])
    near, far = np.linalg.norm(np.diff(vectors, axis=0), axis=1)
    assert near < 0.1
    assert far > 0.5


def test_what_is_no_network_is_refused(tmp_path: Path):
    path = tmp_path / "net.onnx"
    path.write_bytes(b"not a network")
    with pytest.raises(InputError, match="ONNX"):
        Embedding(path)


def test_without_a_network_its_features_are_missing():
    features = extract_features(patch((30, 30, 200)))
    assert isinstance(features, PatchFeatures)
    assert np.isnan(features["embedding 1"])
