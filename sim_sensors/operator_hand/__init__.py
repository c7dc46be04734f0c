"""The scripted hand of a simulated operator.

Only the operator's simulated devices use it.
"""
