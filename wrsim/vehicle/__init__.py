"""Vehicles: plain data (`wheelset`, `vehicle`) and their files (`vehicle_files`, `train_files`)."""
