"""What both sites must agree on."""
