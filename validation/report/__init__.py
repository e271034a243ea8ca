"""Pages made from rows: one module for each report, and what they share."""
