"""Tangential traction on the surface: sliding, partial slip, fretting, tractive rolling."""
