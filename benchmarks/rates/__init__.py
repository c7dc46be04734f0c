"""Speed, correctness and cost of a session at different tick rates."""
