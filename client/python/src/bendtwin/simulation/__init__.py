"""Requests that simulate a twin, with their results: rollouts, plans, registrations and steps."""
