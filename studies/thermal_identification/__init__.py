"""Material and temperature from a touch: speed, accuracy, cost and limits."""
