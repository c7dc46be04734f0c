"""Cost of the camera's pictures: `python -m benchmarks.camera_cost.run`."""
