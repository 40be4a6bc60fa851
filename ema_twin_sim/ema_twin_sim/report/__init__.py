"""A report: one self-contained page that tells a colleague what a model lacked, how sure that is, and what is left."""
