"""Captures on their way to a server: folders as archives, motion capture, resumable uploads."""
