"""Cost of the voice: `python -m benchmarks.voice_cost.run`."""
