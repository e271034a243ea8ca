"""Descent directions of the augmented Lagrangian, one a file."""
