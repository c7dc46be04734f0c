"""`python -m operator_site --config FILE` runs the operator site."""

import sys

from common.config.site_models import OperatorConfig
from common.process import room_main
from operator_site.site import run_operator

sys.exit(room_main("operator_site", {"operator": ("operator", OperatorConfig, run_operator)}))
