"""What to use: Pareto front, recommendation and its verification. May import `engine` and below."""
