"""Contacts in equilibrium at each instant: load histories, wear beside rolling."""
