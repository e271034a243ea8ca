"""Descent directions of the augmented Lagrangian, one in each file."""
