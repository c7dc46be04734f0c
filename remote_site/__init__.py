"""The remote site: reads what the telemanipulator's fingers touch and identifies it."""
