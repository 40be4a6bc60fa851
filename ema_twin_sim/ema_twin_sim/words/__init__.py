"""Sentences and table cells of findings, the same on the terminal, on the page and in the views."""
