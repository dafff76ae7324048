"""Publish and subscribe: the protocol, in memory and over Zenoh."""
