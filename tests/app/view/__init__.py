"""Tests of the page that shows steps and animations."""
