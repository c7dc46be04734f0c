"""Figures of running processes for Prometheus.

The commands use `metrics_server`.
"""
