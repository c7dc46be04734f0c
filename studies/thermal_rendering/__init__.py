"""Temperature at the operator's finger: skin models, integrators, plates and the whole loop."""
