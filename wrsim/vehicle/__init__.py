"""Vehicles: plain data (`wheelset`, `vehicle`) and their files (`vehicle_files`)."""
