"""Tests of izo_ref; the folders are those of the package."""
