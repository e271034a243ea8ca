"""Does the test suite notice? Faults put into a copy of the package, one at a time."""
