"""Pictures: the rerun view of a twin beside its bench, and the page that tells a comparison."""
