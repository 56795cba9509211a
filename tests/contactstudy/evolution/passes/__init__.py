"""Tests of repeated rolling."""
