"""Views in rerun: a twin and its bench, live and from recordings, and the servers that show them."""

import os

# rerun reads this when it is first imported: we report errors ourselves, once
os.environ.setdefault("RUST_LOG", "off")
