"""Readers given files with changed bytes."""
