"""Material from recorded touches of a fabric sensor, beside a linear classifier."""
