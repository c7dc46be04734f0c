"""What the system does under conditions that are set on purpose: each study measures, and draws what it measured."""
