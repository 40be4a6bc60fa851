"""The monitor's services: diagnose which effect the model lacks in the last samples, and add it to the running twin."""
