"""`python -m sim_sensors remote|operator --config FILE` runs the simulated devices of one site."""

import sys

from common.config import SimOperatorConfig, SimRemoteConfig
from common.process import room_main
from sim_sensors.sim_operator import run_sim_operator
from sim_sensors.sim_remote import run_sim_remote

sys.exit(room_main({"remote": (SimRemoteConfig, run_sim_remote), "operator": (SimOperatorConfig, run_sim_operator)}))
