"""A report: one self-contained page that shows what a model lacked, how sure that is, and the error that is left."""
