"""TUM lists: `rgb.txt`, `depth.txt`, one `seconds file` a line."""

from decimal import Decimal, InvalidOperation
from pathlib import Path

from gazemap.errors import InputError

# Times are int64 nanoseconds everywhere.
_END_OF_TIME_NS = 2**63


def read_image_list(path: Path) -> tuple[tuple[int, ...], tuple[Path, ...]]:
    """Return times and files of a list, which must increase and be there."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"cannot be read ({error})", where=path, todo="copy it again") from error
    times: list[int] = []
    paths: list[Path] = []
    for number, line in enumerate(text.splitlines(), start=1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        where = f"{path}, line {number}"
        t_ns, image = _entry(line, where, path.parent)
        if times and t_ns <= times[-1]:
            raise InputError("the time is not after the one above", where=where, todo="sort them")
        times.append(t_ns)
        paths.append(image)
    if not times:
        raise InputError("no image in the list", where=path, todo="list the images")
    return tuple(times), tuple(paths)


def _entry(line: str, where: str, folder: Path) -> tuple[int, Path]:
    fields = line.split()
    if len(fields) < 2:
        raise InputError(f"'seconds file' expected, got '{line}'", where=where, todo="correct it")
    image = folder / fields[1]
    if not image.is_file():
        raise InputError(f"the image {fields[1]} is missing", where=where, todo="add it")
    return seconds_to_ns(fields[0], where=where), image


def seconds_to_ns(text: str, *, where: str) -> int:
    """Return decimal seconds as integer nanoseconds, exactly."""
    try:
        t_ns = int((Decimal(text) * 1_000_000_000).to_integral_value())
    except (InvalidOperation, ValueError, OverflowError):
        t_ns = -1
    if not 0 <= t_ns < _END_OF_TIME_NS:
        raise InputError(
            f"a time in seconds since 1970 expected, got '{text}'", where=where, todo="correct it"
        )
    return t_ns
