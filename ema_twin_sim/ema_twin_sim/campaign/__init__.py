"""Campaigns: many recordings of many units judged by one command, on this machine or on a cluster."""
