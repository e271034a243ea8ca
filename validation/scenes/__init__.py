"""Scenes and zone problems that the studies and tests make, without files."""
