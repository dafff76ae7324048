"""Protobuf messages: one matched encode and decode pair each."""
