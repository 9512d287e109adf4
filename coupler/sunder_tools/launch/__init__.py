"""Installs, builds, starts the two processes, watches and stops them. Uses `report`; knows no pictures."""
