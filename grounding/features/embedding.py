"""An image embedding that the user supplies as an ONNX file."""

from pathlib import Path
from typing import Final

import cv2
import numpy as np

from grounding.errors import InputError
from grounding.features.background import Mask
from grounding.types import FloatArray, ImageArray

EMBEDDING_SIZE: Final = 16
_MEAN_RGB: Final = (123.7, 116.3, 103.5)  # what networks trained on ImageNet expect
_SIGMA: Final = 57.6


class Embedding:
    """A network from the object's box, on black, to a few numbers.

    The network's output, made unit length, is drawn onto `EMBEDDING_SIZE` numbers at random,
    always in the same way: distances are kept about (Johnson and Lindenstrauss 1984), and a few
    patches a word are enough.
    """

    def __init__(self, path: Path, *, side_px: int = 224) -> None:
        """Load the network.

        Args:
            path: an ONNX file with one input (1, 3, side, side) and one output.
            side_px: the side that the network wants.

        Raises:
            InputError: if it cannot be loaded or run.
        """
        self._path, self._side_px = path, side_px
        try:
            self._network = cv2.dnn.readNetFromONNX(str(path))
        except cv2.error as error:
            raise self._unusable(error) from error

    def __call__(self, image_bgr: ImageArray, mask: Mask) -> FloatArray:
        """Return the embedding (16,) of the object in a patch.

        Raises:
            InputError: if the network does not take such an image.
        """
        x, y, width, height = cv2.boundingRect(mask.astype(np.uint8))
        box = (slice(y, y + height), slice(x, x + width))
        thing = np.where(mask[box][..., None], image_bgr[box], np.uint8(0))
        size = (self._side_px, self._side_px)
        blob = cv2.dnn.blobFromImage(thing, 1 / _SIGMA, size, _MEAN_RGB, swapRB=True)
        try:
            self._network.setInput(blob)
            output = np.asarray(self._network.forward(), np.float64).ravel()
        except cv2.error as error:
            raise self._unusable(error) from error
        draw = np.random.default_rng(0).standard_normal((EMBEDDING_SIZE, len(output)))
        length = max(float(np.linalg.norm(output)), 1e-9)
        embedding: FloatArray = draw @ output / length / np.sqrt(EMBEDDING_SIZE)
        return embedding

    def _unusable(self, error: cv2.error) -> InputError:
        reason = str(error).strip().splitlines()[-1] if str(error).strip() else "no reason given"
        todo = f"give an ONNX network with one input (1, 3, {self._side_px}, {self._side_px})"
        return InputError(f"cannot be used ({reason})", where=self._path, todo=todo)
