"""`python -m remote_site --config FILE` runs the remote site."""

import sys

from common.config.site_models import RemoteConfig
from common.process import room_main
from remote_site.site import run_remote

sys.exit(room_main("remote_site", {"remote": ("remote", RemoteConfig, run_remote)}))
