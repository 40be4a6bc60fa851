"""The pictures of rerun's views, of the project's own recordings: ``make pictures`` takes them anew."""
