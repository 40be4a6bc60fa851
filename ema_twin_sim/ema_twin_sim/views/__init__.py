"""Views in rerun: a twin beside its bench, live and from recordings, and the servers that show them."""

import os

# read where rerun is imported first: what goes wrong is told once, by us
os.environ.setdefault("RUST_LOG", "off")
