"""The 3K planetary gearbox (thesis, chapter 3): geometry, mesh stiffness, tooth friction, and the resulting train."""
