"""Quantities of answers, with unit and bound."""
