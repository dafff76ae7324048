"""The processes: the only code that knows Zenoh, sockets, signals and the command line."""
