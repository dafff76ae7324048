"""`gazemap doctor`: what is installed, what is missing, and what to do."""

import sys

import click

from services.doctor import Verdict, examine


@click.command()
def command() -> None:
    """Say what is installed, what is missing, and what to do; exit 1 if something is missing."""
    from rich.console import Console
    from rich.table import Table

    findings = list(examine())
    table = Table("what", "found", "verdict", "to do")
    for each in findings:
        table.add_row(each.name, each.found, each.verdict.value, each.todo)
    Console().print(table)
    if any(each.verdict is Verdict.MISSING for each in findings):
        sys.exit(1)
