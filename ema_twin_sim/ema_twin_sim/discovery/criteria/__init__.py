"""Criteria: the gain an effect needs to be named, and the conditions under which an explanation is accepted."""
