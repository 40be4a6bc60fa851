"""Comparison: residuals, RMSE relative to the sensors' noise, and where a model fails."""
