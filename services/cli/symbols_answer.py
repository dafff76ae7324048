"""`gazemap symbols answer`: tell the running grounding service what a thing on the table is."""

from dataclasses import replace
from pathlib import Path

import click

_CONNECT_TIMEOUT_S = 10.0
_ANSWER_TIMEOUT_S = 30.0


@click.command()
@click.argument("object_id", metavar="OBJECT")
@click.argument("words", nargs=-1, required=True)
@click.option("--group", help="What the words describe; `new` for a name of one thing.")
@click.option("--connect", help="Where the router listens, over what the file says.")
@click.option("--config", "file", type=click.Path(path_type=Path), help="TOML file.")
def answer(
    object_id: str,
    words: tuple[str, ...],
    *,
    group: str | None,
    connect: str | None,
    file: Path | None,
) -> None:
    """Answer a question of the grounding service: OBJECT, as it stands now, is called WORDS."""
    import threading

    from gazemap.config import load_config
    from gazemap.errors import InputError
    from gazemap.wire.streams import Stream
    from services.bus.zenoh import ZenohConfig
    from services.bus.zenoh import connect as connected
    from services.wire import queries

    config = load_config(ZenohConfig, file) if file else ZenohConfig()
    config = config if connect is None else replace(config, endpoint=connect)
    bus = connected(replace(config, connect_timeout_s=_CONNECT_TIMEOUT_S), stop=threading.Event())
    if bus is None:
        raise AssertionError
    lesson = {"words": list(words), "object": object_id, "group": group}
    with bus:
        reply = bus.ask(
            Stream.TEACH, queries.encode_teach_request(lesson), timeout_s=_ANSWER_TIMEOUT_S
        )
    if reply is None:
        raise InputError(
            "nothing was learnt",
            where=config.endpoint,
            todo="see the line above, or start `gazemap serve grounding`",
        )
    click.echo(f"learnt: {object_id} is {' '.join(words)}")
