"""What a scene requires of a grid, the plan, and what a solve costs. May import `accuracy` and below."""
