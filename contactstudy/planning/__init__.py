"""Plans: requirements of a scene on its grid, and the cost of a solve. May import `progress` and below."""
