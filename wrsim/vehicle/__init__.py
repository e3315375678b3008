"""Vehicles: plain data (`wheelset`) and their files (`files`)."""
