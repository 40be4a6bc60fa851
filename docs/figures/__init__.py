"""The figures and numbers of docs/physics.md, one file a figure: ``make figures`` draws and measures them anew."""
