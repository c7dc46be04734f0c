"""The simulated world: hand, objects, heat, surfaces.

Devices read it. It knows no device and no model of the sites.
"""
