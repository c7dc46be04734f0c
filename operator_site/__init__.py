"""The operator site: makes five fingertips feel what the remote fingers touch."""
