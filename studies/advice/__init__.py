"""Advice on settings: Pareto front, recommendation and its verification. May import `engine` and below."""
