"""A Zenoh router with the rules of `deploy/`: the wheel's own session in router mode."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import zenoh

from gazemap.errors import InputError

DEFAULT_RULES: Final = Path(__file__).resolve().parents[1] / "deploy" / "zenoh.json5"
_ANYONE_HERE: Final = "this-machine"


@dataclass(frozen=True, slots=True, kw_only=True)
class RouterConfig:
    """What a router is started with.

    Attributes:
        rules: a Zenoh configuration file.
        endpoint: where to listen instead of where the file says.
        users: file of `role:password` lines; with it every role has its own rules alone.
    """

    rules: Path = DEFAULT_RULES
    endpoint: str | None = None
    users: Path | None = None


@contextmanager
def running_router(config: RouterConfig) -> Iterator[None]:
    """Route until the block ends.

    Raises:
        InputError: if a file cannot be used or the endpoint is taken.
    """
    try:
        native = zenoh.Config.from_file(config.rules)
        _apply(native, config)
        session = zenoh.open(native)
    except zenoh.ZError as error:
        first = str(error).partition(" at /")[0]
        todo = "correct the file, or choose another --listen if the address is in use"
        raise InputError(f"no router started: {first}", where=config.rules, todo=todo) from error
    with session:
        yield


def _apply(native: zenoh.Config, config: RouterConfig) -> None:
    if config.endpoint is not None:
        native.insert_json5("listen/endpoints", json.dumps([config.endpoint]))
    if config.users is None:
        return
    if not config.users.is_file():
        todo = "write lines `role:password` into it"
        raise InputError("no such file", where=config.users, todo=todo)
    native.insert_json5(
        "transport/auth/usrpwd/dictionary_file", json.dumps(str(config.users.resolve()))
    )
    # Who has a password is known by it; being on this machine then gives no right of its own.
    policies = json.loads(native.get_json("access_control/policies"))
    named = [each for each in policies if _ANYONE_HERE not in each["subjects"]]
    native.insert_json5("access_control/policies", json.dumps(named))
