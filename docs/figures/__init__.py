"""The figures of docs/physics.md and docs/architecture.md, one file a figure, and the numbers of the former: ``make
figures`` draws and measures them anew.
"""
