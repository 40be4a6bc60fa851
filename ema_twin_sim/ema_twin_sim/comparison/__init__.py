"""Comparison: residuals, RMSE beside the sensors' noise, and where a model fails."""
