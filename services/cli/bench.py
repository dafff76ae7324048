"""`gazemap bench NAME`: measure a part and print the figures."""

import importlib
import pkgutil

import click

import services.bench
from services.bench.figures import Figure

_NOT_A_BENCH = "figures"


def bench_names() -> list[str]:
    """Return the names that can be measured: one module each in services/bench."""
    found = (module.name for module in pkgutil.iter_modules(services.bench.__path__))
    return sorted(name for name in found if name != _NOT_A_BENCH)


@click.command()
@click.argument("name", type=click.Choice([*bench_names(), "all"]))
def command(name: str) -> None:
    """Measure a part; every figure stands beside a peer's from the same run."""
    for each in bench_names() if name == "all" else [name]:
        figures: list[Figure] = importlib.import_module(f"services.bench.{each}").run()
        _print_table(each, figures)


def _print_table(name: str, figures: list[Figure]) -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table("figure", "value", "unit", "peer", "peer's", "ratio", title=f"bench {name}")
    for figure in figures:
        peers = "" if figure.peer_value is None else f"{figure.peer_value:.4g}"
        ratio = "" if figure.ratio is None else f"{figure.ratio:.3g}"
        table.add_row(figure.name, f"{figure.value:.4g}", figure.unit, figure.peer, peers, ratio)
    Console().print(table)
