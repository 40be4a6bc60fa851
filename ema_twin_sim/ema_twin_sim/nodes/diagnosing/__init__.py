"""The monitor's services: which effect the model lacks beside the last samples, and adding it to the running twin."""
