"""Data that belongs to the project: `scenes/`, small steps with the commands that make them."""
