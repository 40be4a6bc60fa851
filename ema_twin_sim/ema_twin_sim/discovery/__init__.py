"""Discovery: which physical effect a model lacks, how sure that is, and what the data cannot tell."""
