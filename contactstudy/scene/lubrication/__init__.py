"""Lubrication of a scene: the lubricant and its laws, the heat of its film, the motion that entrains it."""
