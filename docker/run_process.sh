#!/bin/sh
# Runs the process named by $PROCESS with /config/$PROCESS.toml.
exec python -m teletaction "$PROCESS" --config "/config/$PROCESS.toml"
