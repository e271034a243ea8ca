"""Kernels of a GPU: gather, call, store. Imported only after a GPU was found."""
