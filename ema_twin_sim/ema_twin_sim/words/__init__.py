"""Words: what was found, told alike in the terminal, on the page and in the views."""
