"""`python -m services.cli`: the console script without its installation."""

from services.cli.main import main

main()
