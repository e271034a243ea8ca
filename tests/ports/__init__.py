"""Ports that the tests run through `izo conform`."""
