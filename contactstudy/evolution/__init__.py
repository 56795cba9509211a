"""Contacts and films that change in time: state variables, integration, rolling, results."""
