"""Our own compiled functions as a port: one file for each stage."""
