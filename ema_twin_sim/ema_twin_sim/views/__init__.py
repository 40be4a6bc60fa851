"""Pictures: the rerun view of a twin beside its bench, and the page that tells a comparison."""

import os

# read where rerun is imported first: what goes wrong is told once, by us
os.environ.setdefault("RUST_LOG", "off")
