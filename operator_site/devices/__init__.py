"""Drives the exoskeleton and the fingertip modules, and checks their measurements.

The site imports only `devices`. Drivers import no gate.
"""
