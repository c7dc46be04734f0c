"""Speed of encrypting and decrypting recordings."""
