"""Contacts in equilibrium at each instant: load histories, wear beside rolling, films over bodies that yield."""
