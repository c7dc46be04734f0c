"""Base of the models of files that people write."""

from pydantic import BaseModel, ConfigDict


class StrictModel(BaseModel):
    """A table of a file. Unknown fields, and numbers that are infinite or NaN, are errors."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)
