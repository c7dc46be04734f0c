"""`python -m sim_sensors remote|operator|network --config FILE` runs one site's devices, or the network."""

import sys

from common.config.simulation_models import SimNetworkConfig, SimOperatorConfig, SimRemoteConfig
from common.process import room_main
from sim_sensors.network.proxy import run_sim_network
from sim_sensors.operator_devices import run_sim_operator
from sim_sensors.remote_devices import run_sim_remote

sys.exit(
    room_main(
        "sim_sensors",
        {
            "remote": ("sim-remote", SimRemoteConfig, run_sim_remote),
            "operator": ("sim-operator", SimOperatorConfig, run_sim_operator),
            "network": ("sim-network", SimNetworkConfig, run_sim_network),
        },
    )
)
