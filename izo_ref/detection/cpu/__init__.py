"""Kernels of the CPU: gather, call, store."""
