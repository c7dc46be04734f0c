#!/bin/sh
# Runs the process named by $PROCESS with /config/$PROCESS.toml. What an earlier run recorded is set aside first:
# a process that was restarted must not overwrite the minutes before.
set -eu
recording=/session/$PROCESS.mcap
if [ -e "$recording" ]; then
    number=1
    while [ -e "/session/$PROCESS-$number.mcap" ]; do number=$((number + 1)); done
    mv "$recording" "/session/$PROCESS-$number.mcap"
fi
exec python -m teletaction "$PROCESS" --config "/config/$PROCESS.toml"
