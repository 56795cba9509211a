"""Laws of friction of a scene: full sliding, partial slip, fretting, rolling with creepage."""
