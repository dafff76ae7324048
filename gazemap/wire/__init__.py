"""The wire format: one matched encode/decode pair a message, on the bus as in a recording."""
